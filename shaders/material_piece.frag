#version 460
#extension GL_GOOGLE_include_directive : require
#include "grain.glsl"
#include "mesh_material.glsl"
#include "piece.glsl"

layout(location = 2) in vec3 smooth_normal;
layout(location = 3) in vec3 in_object;
layout(location = 4) in vec2 uv;
layout(location = 5) in vec4 vertex_colour;
layout(location = 6) flat in uint material;
layout(location = 7) flat in int grain;

// The texture of fracture surfaces, from three sides, repeated every metre; v points down.
vec3 cut_texture(uint layer, vec3 to_right, vec3 to_below) {
    vec3 across = abs(cross(to_right, to_below));
    vec3 weight = pow(across / max(max(across.x, across.y), max(across.z, 1e-30)), vec3(6.0));
    vec3 sum = weight.x * texel(base_colours, layer, TexturePlace(-in_object.zy, -to_right.zy, -to_below.zy), 0u).rgb;
    sum += weight.y * texel(base_colours, layer, TexturePlace(in_object.xz, to_right.xz, to_below.xz), 0u).rgb;
    sum += weight.z
           * texel(base_colours, layer,
                   TexturePlace(in_object.xy * vec2(1.0, -1.0), to_right.xy * vec2(1.0, -1.0),
                                to_below.xy * vec2(1.0, -1.0)),
                   0u)
                 .rgb;
    return sum / (weight.x + weight.y + weight.z);
}

// Bends a normal by a normal map. The tangents follow from derivatives (Schueler 2013, "Normal mapping without
// precomputed tangents"), so no vertex needs any.
vec3 bent(vec3 normal, MeshMaterial m, TexturePlace place, vec3 to_right, vec3 to_below) {
    place = transformed(place, m.normal_uv, m.uv_offset.zw);
    vec3 map = 2.0 * texel(normal_maps, m.normal_layer, place, m.normal_flags).xyz - 1.0;
    map.xy *= m.numbers.y;
    vec3 right = cross(normal, to_below), below = cross(to_right, normal);
    vec3 tangent = right * place.to_right.x + below * place.to_below.x;
    vec3 bitangent = right * place.to_right.y + below * place.to_below.y; // towards larger v, down in the image
    float longest = max(dot(tangent, tangent), dot(bitangent, bitangent));
    if (!(longest > 0.0)) return normal;
    float scale = inversesqrt(longest);
    vec3 result = map.x * scale * tangent - map.y * scale * bitangent + map.z * normal;
    float squared = dot(result, result);
    return squared > 0.0 ? result * inversesqrt(squared) : normal;
}

void main() {
    // Derivatives come before anything that may end the fragment.
    vec3 facet = flat_normal();
    TexturePlace place = TexturePlace(uv, dFdx(uv), dFdy(uv));
    vec3 to_right = dFdx(in_object), to_below = dFdy(in_object); // in the object
    vec3 world_right = dFdx(from_eye), world_below = dFdy(from_eye);
    discard_faded(albedo.a);
    vec3 normal = frame.cuts.y != 0.0 && dot(smooth_normal, facet) > 0.0 ? normalize(smooth_normal) : facet;
    vec3 reflected = albedo.rgb;
    float gloss = 0.0;
    if (material != 0u) {
        MeshMaterial m = mesh_materials[material - 1u];
        vec4 base = base_colour(m, place, vertex_colour);
        discard_cut_out(m, base.a);
        reflected = base.rgb;
        if (m.normal_layer != 0u) normal = bent(normal, m, place, world_right, world_below);
    } else if (grain < 0) {
        uint own = uint(-1 - grain);
        reflected = weathered(own, albedo.rgb, in_object, max(length(to_right), length(to_below)));
        gloss = gloss_of(own);
    } else {
        uint layer = uint(frame.cuts.x);
        float pixel = max(length(to_right), length(to_below));
        reflected =
            layer != 0u ? cut_texture(layer, to_right, to_below) : grained(uint(grain), albedo.rgb, in_object, pixel);
    }
    light_piece(reflected, facet, normal, gloss);
}
