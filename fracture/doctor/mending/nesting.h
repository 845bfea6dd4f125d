// Which closed parts of a mesh lie inside which, whichever way they face.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture::mending {

// Per part the number of other closed parts around it; 0 for parts that are not closed. Eight points at most
// are looked at on each: all of them must lie inside, or on the surface, and one inside. So of parts that
// pass through each other neither is nested. `part_of` is per triangle, `closed` per part.
[[nodiscard]] std::vector<uint32_t> nesting_depths(const TriangleMesh& mesh, std::span<const uint32_t> part_of,
                                                   std::span<const uint8_t> closed);

} // namespace brittle::fracture::mending
