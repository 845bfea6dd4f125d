// Joins vertices at equal positions.
//
// File formats split a vertex wherever its normal or texture coordinates jump (STL splits them all), which
// opens the mesh along every such seam. Joining them by position closes it again. Only equality counts: no
// tolerance decides topology, and parts that merely come close stay apart.
#pragma once

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// Vertices at bit-equal positions (-0 equals +0) become one, the first; then triangles that name a vertex
// twice are dropped, and vertices that no triangle uses. Order is kept. Expected linear time. Indices must be
// in range. `kept`, where given, gets the index of each remaining triangle in the mesh.
[[nodiscard]] TriangleMesh weld(const TriangleMesh& mesh, std::vector<uint32_t>* kept = nullptr);

} // namespace brittle::fracture
