#version 460
#extension GL_GOOGLE_include_directive : require
// Depth of the pieces seen from the light; without fragment shader.
#include "frame.glsl"

layout(location = 0) in vec3 position;

void main() {
    vec3 world = transform_vertex(draws[gl_InstanceIndex], position, vec3(0.0));
    gl_Position = frame.shadow_clip_from_world * vec4(world, 1.0);
}
