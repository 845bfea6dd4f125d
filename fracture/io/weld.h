// Welds vertices at equal positions.
//
// File formats split a vertex where its normal or texture coordinates are discontinuous (STL splits all vertices),
// which opens the mesh along every seam. Welding by position closes it again. Only equality counts: no tolerance
// decides topology, and parts that merely come close stay apart.
#pragma once

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// Merges vertices at bit-equal positions (-0 equals +0) into the first of them, then drops triangles that name a vertex
// twice, and vertices without triangles. Order is kept. Expected linear time. Indices must be in range. `kept`, where
// given, receives the index in `mesh` of each remaining triangle.
[[nodiscard]] TriangleMesh weld(const TriangleMesh& mesh, std::vector<uint32_t>* kept = nullptr);

} // namespace brittle::fracture
