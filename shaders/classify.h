// What the classification's shaders and C++ share: both compile this file.
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

const uint classify_binding_positions = 0;      // float, three a vertex
const uint classify_binding_sites = 1;          // vec4, by bin: position; w: the index's bits
const uint classify_binding_bins = 2;           // uint, bins + 1: where a bin's sites begin
const uint classify_binding_vertex_answers = 3; // uint, one a vertex
const uint classify_binding_triangles = 4;      // uint, three a triangle
const uint classify_binding_triangle_answers = 5;
const uint classify_binding_site_positions = 6;         // vec4, by index: position of a site
const uint classify_binding_crossing = 7;       // uint: crossing triangles, in any order
const uint classify_binding_crossing_count = 8; // uint
const uint classify_binding_dispatch = 9;       // VkDispatchIndirectCommand of the pass over them
const uint classify_binding_count = 10;

// As in fracture/classifier.h.
const uint classify_uncertain = 0x80000000u;
const uint classify_crossing = 0x80000000u;
const uint classify_edge_alone = 1u; // << edge
const uint classify_point_alone = 8u;
const uint classify_sign_known = 16u; // << 2 edge
const uint classify_sign_first = 32u; // << 2 edge

// Push constants.
struct ClassifyGrid {
    vec4 low;      // corner of the first bin; w: the largest coordinate of a vertex
    vec4 bin_size; // w: unused
    uvec4 bins;    // along each axis; w: vertices
    uvec4 counts;  // x: triangles; the rest unused
};

#ifdef __cplusplus
static_assert(sizeof(ClassifyGrid) == 64);
} // namespace brittle::engine::shared
#endif

#endif
