// Constants and structs of the classification, shared by C++ and GLSL: both compile this file.
#ifndef BRITTLE_SHADERS_CLASSIFY_H
#define BRITTLE_SHADERS_CLASSIFY_H

#ifdef __cplusplus
#include <cstdint>

#include <glm/vec4.hpp>

namespace brittle::engine::shared {
using uint = uint32_t;
using glm::uvec4;
using glm::vec4;
#endif

const uint classify_group_size = 128;

const uint classify_binding_positions = 0;        // float, three for each vertex
const uint classify_binding_sites = 1;            // vec4, grouped by bin: position; w: the bits of the site's index
const uint classify_binding_bins = 2;             // uint, bins + 1: index of each bin's first site
const uint classify_binding_vertex_answers = 3;   // uint, one for each vertex
const uint classify_binding_triangles = 4;        // uint, three vertex indices for each triangle
const uint classify_binding_triangle_answers = 5; // uint, one for each triangle
const uint classify_binding_site_positions = 6;   // vec4, by index: position of a site
const uint classify_binding_crossing = 7;         // uint: indices of crossing triangles, in any order
const uint classify_binding_crossing_count = 8;   // uint: their number
const uint classify_binding_dispatch = 9;         // VkDispatchIndirectCommand of the pass over the crossing triangles
const uint classify_binding_count = 10;

// Bits of the answers, equal to those of fracture/classifier.h, which documents them.
const uint classify_uncertain = 0x80000000u;
const uint classify_crossing = 0x80000000u;
const uint classify_edge_alone = 1u; // << edge
const uint classify_point_alone = 8u;
const uint classify_sign_known = 16u; // << 2 edge
const uint classify_sign_first = 32u; // << 2 edge

// Push constants.
struct ClassifyGrid {
    vec4 low;      // minimum corner of the grid; w: the largest absolute coordinate of the mesh's box
    vec4 bin_size; // w: unused
    uvec4 bins;    // number of bins along each axis; w: number of vertices
    uvec4 counts;  // x: number of triangles; the rest unused
};

#ifdef __cplusplus
static_assert(sizeof(ClassifyGrid) == 64);
} // namespace brittle::engine::shared
#endif

#endif
