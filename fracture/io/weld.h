// Welds vertices at equal positions.
//
// File formats split a vertex where its normal or texture coordinates are discontinuous (STL splits all vertices),
// which opens the mesh along every seam. Welding by position closes it again. Only equality counts: no tolerance
// decides topology, and parts that merely come close stay apart. Parts of a solid, or several solids, may touch along an
// edge; there a weld would join four triangles, and weld_surface() keeps the parts apart.
#pragma once

#include <span>
#include <vector>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// Merges vertices at bit-equal positions (-0 equals +0) into the first of them, then drops triangles that name a vertex
// twice, and vertices without triangles. Order is kept. Expected linear time. Indices must be in range. `kept`, where
// given, receives the index in `mesh` of each remaining triangle.
[[nodiscard]] TriangleMesh weld(const TriangleMesh& mesh, std::vector<uint32_t>* kept = nullptr);

// Welds as weld() does. Where that gives no manifold, returns the first of these in which every edge is shared by two
// triangles that face the same way, else the welded mesh:
//  1. the mesh with its own vertices, or, where `point` gives a number for each vertex, with those of equal position and
//     number. It keeps triangles whose corners share a position.
//  2. the welded mesh with the vertices of edges of three triangles or more divided into fans. Corners at one vertex of
//     `mesh` stay together.
[[nodiscard]] TriangleMesh weld_surface(const TriangleMesh& mesh, std::span<const uint32_t> point,
                                        std::vector<uint32_t>& kept);

} // namespace brittle::fracture
