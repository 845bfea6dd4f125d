#version 460
#extension GL_GOOGLE_include_directive : require
#include "mesh_material.glsl"

layout(location = 0) flat in uint id;
layout(location = 1) flat in float opacity;
layout(location = 2) in vec3 uv_and_alpha;
layout(location = 3) flat in uint material;
layout(location = 0) out uint colour;

void main() {
    TexturePlace place = TexturePlace(uv_and_alpha.xy, dFdx(uv_and_alpha.xy), dFdy(uv_and_alpha.xy));
    discard_faded(opacity);
    if (material != 0u) {
        MeshMaterial m = mesh_materials[material - 1u];
        discard_cut_out(m, base_colour(m, place, vec4(1.0, 1.0, 1.0, uv_and_alpha.z)).a);
    }
    colour = id;
}
