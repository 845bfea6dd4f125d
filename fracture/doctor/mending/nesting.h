// Finds which closed parts of a mesh lie inside which, for any orientation.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture::mending {

// Returns for each part the number of other closed parts around it; 0 for a part that is not closed. At most eight
// points of each part are sampled: one of them must lie inside the other part, and all inside or on its surface. So of
// two parts that pass through each other neither is nested. `part_of` is per triangle, `closed` per part.
[[nodiscard]] std::vector<uint32_t> nesting_depths(const TriangleMesh& mesh, std::span<const uint32_t> part_of,
                                                   std::span<const uint8_t> closed);

} // namespace brittle::fracture::mending
