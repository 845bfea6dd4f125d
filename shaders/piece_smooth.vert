#version 460
#extension GL_GOOGLE_include_directive : require
// Pieces with a normal for each vertex (piece.vert has none). Interior faces are flat-shaded, with the normal 0.
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 0) out vec3 from_eye;
layout(location = 1) flat out vec4 albedo;
layout(location = 2) out vec3 smooth_normal;

void main() {
    DrawData draw = draws[gl_InstanceIndex];
    from_eye = transform_vertex(draw, position, frame.eye.xyz);
    albedo = albedo_of(draw);
    smooth_normal = draw.material % 2 == material_exterior ? rotate(poses[draw.body].rotation, normal) : vec3(0.0);
    gl_Position = frame.clip_from_eye * vec4(from_eye, 1.0);
}
