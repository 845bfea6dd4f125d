#version 460
#extension GL_GOOGLE_include_directive : require
// Pieces. Each draw range is one instance; gl_InstanceIndex, the command's first instance, is the index of the range.
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 0) out vec3 from_eye;
layout(location = 1) flat out vec4 albedo;

void main() {
    DrawData draw = draws[gl_InstanceIndex];
    from_eye = transform_vertex(draw, position, frame.eye.xyz);
    albedo = albedo_of(draw);
    gl_Position = is_clear(draw) ? nowhere : frame.clip_from_eye * vec4(from_eye, 1.0);
}
