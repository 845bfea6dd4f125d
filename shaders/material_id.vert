#version 460
#extension GL_GOOGLE_include_directive : require
// Ids of pieces with materials that are cut out.
#include "material_vertex.glsl"

layout(location = 0) flat out uint id;
layout(location = 1) flat out float opacity;
layout(location = 2) out vec3 uv_and_alpha;
layout(location = 3) flat out uint material;

void main() {
    DrawData draw = draws[gl_InstanceIndex];
    id = draw.id;
    opacity = unpackUnorm4x8(draw.tint).a;
    material = material_of(draw);
    uv_and_alpha = material != 0u ? vec3(texture_uv, vertex_srgb.a) : vec3(0.0);
    gl_Position = frame.clip_from_eye * vec4(transform_vertex(draw, position, frame.eye.xyz), 1.0);
}
