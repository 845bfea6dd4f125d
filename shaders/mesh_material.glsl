// Descriptor set 2: the materials of meshes and their textures.
#ifndef BRITTLE_MESH_MATERIAL_GLSL
#define BRITTLE_MESH_MATERIAL_GLSL

#include "fade.glsl"
#include "shared.h"

layout(constant_id = constant_cut_out) const bool cut_out = false;
layout(set = 2, binding = binding_mesh_materials, std430) readonly buffer MeshMaterialBlock {
    MeshMaterial mesh_materials[];
};
layout(set = 2, binding = binding_base_colours) uniform sampler2DArray base_colours;
layout(set = 2, binding = binding_normal_maps) uniform sampler2DArray normal_maps;

// A place in a texture, with its differences to the next pixels: those of wrapped coordinates jump at the border.
struct TexturePlace {
    vec2 at, to_right, to_below;
};

float wrapped(float x, uint wrap, float half_texel) {
    if (wrap == 0u) return x;
    if ((wrap & wrap_mirror) != 0u) x = 1.0 - abs(2.0 * fract(0.5 * x) - 1.0);
    return clamp(x, half_texel, 1.0 - half_texel);
}

TexturePlace transformed(TexturePlace place, vec4 columns, vec2 offset) {
    mat2 turn = mat2(columns.xy, columns.zw);
    return TexturePlace(turn * place.at + offset, turn * place.to_right, turn * place.to_below);
}

vec4 texel(sampler2DArray layers, uint layer, TexturePlace place, uint flags) {
    vec2 texels = vec2(textureSize(layers, 0).xy);
    // Of the coarser level that the filter reads: beyond it lies the other end of the texture.
    float footprint = max(length(place.to_right * texels), length(place.to_below * texels));
    vec2 half_texel = min(vec2(0.5), 0.5 * max(1.0, 2.0 * footprint) / texels);
    const uint mask = (1u << wrap_bits) - 1u;
    vec2 at = vec2(wrapped(place.at.x, flags & mask, half_texel.x),
                   wrapped(place.at.y, flags >> wrap_bits & mask, half_texel.y));
    return textureGrad(layers, vec3(at, float(layer - 1u)), place.to_right, place.to_below);
}

// Returns the base colour of a material at a vertex colour, in linear light, with opacity.
vec4 base_colour(MeshMaterial material, TexturePlace place, vec4 vertex_colour) {
    vec4 colour = material.colour * vertex_colour;
    if (material.base_layer != 0u)
        colour *= texel(base_colours, material.base_layer,
                        transformed(place, material.base_uv, material.uv_offset.xy), material.base_flags);
    return colour;
}

// Discards the fragment where the material is cut out. A blended material covers a share of the pixels.
void discard_cut_out(MeshMaterial material, float opacity) {
    if (!cut_out) return;
    if ((material.base_flags & alpha_mask) != 0u && opacity < material.numbers.x) discard;
    if ((material.base_flags & alpha_blend) != 0u && 64.0 * opacity <= float(bayer_rank(uvec2(gl_FragCoord.xy))) + 0.5)
        discard;
}

#endif
