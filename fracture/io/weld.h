// Joins vertices at equal positions.
#pragma once

#include "fracture/mesh.h"

namespace brittle::fracture {

// Vertices at bit-equal positions (-0 equals +0) become one, the first; unused vertices are dropped, order is kept;
// triangles that then name a vertex twice are dropped. Linear time.
[[nodiscard]] TriangleMesh weld(const TriangleMesh& mesh);

} // namespace brittle::fracture
