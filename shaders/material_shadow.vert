#version 460
#extension GL_GOOGLE_include_directive : require
// Depth, seen from the light, of pieces with materials that are cut out; material_cut_out.frag discards pixels. A draw
// may hold the interior of a piece, too, whose vertices have no material.
#include "material_vertex.glsl"

layout(location = 1) flat out float opacity;
layout(location = 2) out vec3 uv_and_alpha;
layout(location = 3) flat out uint material;

void main() {
    DrawData draw = draws[gl_InstanceIndex];
    opacity = unpackUnorm4x8(draw.tint).a;
    material = material_of(draw);
    uv_and_alpha = material != 0u ? vec3(texture_uv, vertex_srgb.a) : vec3(0.0);
    vec4 at = frame.shadow_clip_from_world * vec4(transform_vertex(draw, position, vec3(0.0)), 1.0);
    gl_Position = is_clear(draw) ? nowhere : at;
}
