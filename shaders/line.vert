#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec4 srgb;
layout(location = 0) flat out vec4 colour;

void main() {
    colour = srgb;
    gl_Position = line_position(position - frame.eye.xyz);
}
