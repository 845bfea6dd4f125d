// Closes a patch of a closed surface by other triangles, so that it bounds a solid which is right near a place.
//
// Take the triangles of a closed surface that meet a convex region, and some more around them. Replace all others by
// any triangles that have the same border and stay outside the region. What changes is a closed surface outside the
// region, so the winding numbers in the region change by one constant, and boxes around everything make up for it. A
// cut whose cells lie in the region then gives the same pieces as a cut of the whole surface.
//
// The triangles added, the lids: a strip from each loop of the border straight away from the region, and a cone over
// its far end with an apex much farther out. A ray that leaves a convex region never comes back, so a strip stays
// outside; the cones are tested.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// The border of a patch, in closed loops of vertices along the half-edges of its triangles. `outer` holds all triangles
// that have a vertex on the border, and may hold others; `inner` is 1, by vertex, where that is not on the border.
// Precondition: the patch is manifold but for its border.
[[nodiscard]] std::vector<std::vector<uint32_t>> border_loops(std::span<const Triangle> outer,
                                                              std::span<const uint8_t> inner);

// Adds lids to a patch, after its own triangles and vertices. Precondition: no edge of the border meets the region.
// `original` receives, by vertex, the index of the patch's vertex that it is or was split from; no_index for those of
// lids. Returns false where no lids were found that stay outside the region.
[[nodiscard]] bool add_lids(TriangleMesh& patch, std::span<const std::vector<uint32_t>> border, const Box& region,
                            std::vector<uint32_t>& original);

// Adds `count` boxes around all of the mesh, each wider than the one before, turned inside out where count is negative.
void add_boxes(TriangleMesh& mesh, int count);

} // namespace brittle::fracture
