#version 460
#extension GL_GOOGLE_include_directive : require
// Depth of splinters seen from the light, one instance for each; without fragment shader.
#include "splinter.glsl"

void main() {
    gl_Position = frame.shadow_clip_from_world * vec4(splinter_vertex(gl_VertexIndex, vec3(0.0)), 1.0);
}
