// What the vertex shaders of pieces with materials share: the attributes, and those that a cut-out needs.
#ifndef BRITTLE_MATERIAL_VERTEX_GLSL
#define BRITTLE_MATERIAL_VERTEX_GLSL

#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 2) in vec2 texture_uv;
layout(location = 3) in vec4 vertex_srgb;
layout(location = 4) in uint vertex_material; // 1 + material in the mesh, or 0

// Returns 1 + the index of the vertex's MeshMaterial, or 0. Interior vertices, and pieces of meshes without materials,
// have none; the attributes of the latter are undefined.
uint material_of(DrawData draw) {
    uint first = uint(draw.object.w);
    bool has_one = first != 0u && draw.material % 2 == material_exterior && vertex_material != 0u;
    return has_one ? first + vertex_material - 1u : 0u;
}

#endif
