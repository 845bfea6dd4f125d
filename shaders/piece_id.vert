#version 460
#extension GL_GOOGLE_include_directive : require
// Ids of the pieces; 0 in pixels without a piece.
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 0) flat out uint id;
layout(location = 1) flat out float opacity;

void main() {
    DrawData draw = draws[gl_InstanceIndex];
    id = draw.id;
    opacity = unpackUnorm4x8(draw.tint).a;
    gl_Position = frame.clip_from_eye * vec4(transform_vertex(draw, position, frame.eye.xyz), 1.0);
}
