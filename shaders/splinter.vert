#version 460
#extension GL_GOOGLE_include_directive : require
// Splinters of a scene, one instance for each; piece.frag shades them.
#include "splinter.glsl"

layout(location = 0) out vec3 from_eye;
layout(location = 1) flat out vec4 albedo;

void main() {
    from_eye = splinter_vertex(gl_VertexIndex, frame.eye.xyz);
    albedo = vec4(colour_and_width.rgb, 1.0);
    gl_Position = frame.clip_from_eye * vec4(from_eye, 1.0);
}
