#version 460
#extension GL_GOOGLE_include_directive : require
// Triangle edges of the pieces, in one colour.
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 0) flat out vec4 srgb;

void main() {
    srgb = vec4(0.10, 0.11, 0.13, 1.0);
    gl_Position = line_position(transform_vertex(draws[gl_InstanceIndex], position, frame.eye.xyz));
}
