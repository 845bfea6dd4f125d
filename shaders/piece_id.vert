#version 460
#extension GL_GOOGLE_include_directive : require
// The number of each piece, from 1: 0 is where there is none.
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 0) flat out uint id;

void main() {
    DrawData draw = draws[gl_InstanceIndex];
    id = draw.piece + 1;
    gl_Position = frame.clip_from_eye * vec4(place(poses[draw.body], position, frame.eye.xyz), 1.0);
}
