#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec4 srgb;
layout(location = 0) flat out vec4 colour;

// Lines on a surface must win against it: they come nearer by a fraction of their depth.
const float nearer = 2e-4;

void main() {
    colour = srgb;
    gl_Position = frame.clip_from_eye * vec4(position - frame.eye.xyz, 1.0);
    gl_Position.z -= nearer * gl_Position.w;
}
