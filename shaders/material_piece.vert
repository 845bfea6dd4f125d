#version 460
#extension GL_GOOGLE_include_directive : require
// Pieces with the materials of their mesh, and those without any in the view of materials.
#include "material_vertex.glsl"
#include "srgb.glsl"

layout(location = 1) in vec3 normal;
layout(location = 0) out vec3 from_eye;
layout(location = 1) flat out vec4 albedo;
layout(location = 2) out vec3 smooth_normal;
layout(location = 3) out vec3 in_object;
layout(location = 4) out vec2 uv;
layout(location = 5) out vec4 vertex_colour;
layout(location = 6) flat out uint material; // 1 + index of the MeshMaterial, or 0
layout(location = 7) flat out int grain;     // of a fracture surface; -1 - grain of an exterior

void main() {
    DrawData draw = draws[gl_InstanceIndex];
    bool exterior = draw.material % 2 == material_exterior;
    from_eye = transform_vertex(draw, position, frame.eye.xyz);
    vec4 look = frame.materials[draw.material];
    albedo = vec4(look.rgb, unpackUnorm4x8(draw.tint).a);
    smooth_normal = exterior ? rotate(poses[draw.body].rotation, normal) : vec3(0.0);
    in_object = position + draw.offset.xyz + draw.object.xyz;
    material = material_of(draw);
    int own = int(frame.materials[draw.material | material_interior].w);
    grain = !exterior ? own : draw.object.w == 0.0 ? -1 - own : -1 - int(grain_plain);
    uv = material != 0u ? texture_uv : vec2(0.0);
    vertex_colour = material != 0u ? vec4(linear_of(vertex_srgb.rgb), vertex_srgb.a) : vec4(1.0);
    gl_Position = is_clear(draw) ? nowhere : frame.clip_from_eye * vec4(from_eye, 1.0);
}
