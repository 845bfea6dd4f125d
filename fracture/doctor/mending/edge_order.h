// Sorts the triangles around an edge by angle, exactly.
#pragma once

#include <cstdint>
#include <vector>

#include "fracture/doctor/mending/work.h"

namespace brittle::fracture::mending {

// Returns indices into `uses`, the uses of one edge, counter-clockwise as seen from its higher end, from an arbitrary
// start. Of triangles in one half-plane those that run forward come first: their solid ends there, and the solid of the
// others begins.
[[nodiscard]] std::vector<uint32_t> around_edge(const TriangleMesh& mesh, std::span<const EdgeUse> uses);

} // namespace brittle::fracture::mending
