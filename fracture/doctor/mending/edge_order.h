// The triangles around an edge by angle, exactly.
#pragma once

#include <cstdint>
#include <vector>

#include "fracture/doctor/mending/work.h"

namespace brittle::fracture::mending {

// Indices into `uses`, which are those of one edge: counter-clockwise seen from its higher end, beginning
// anywhere. Of triangles in one half-plane those that run forward come first: their solid ends there, that of
// the others begins.
[[nodiscard]] std::vector<uint32_t> around_edge(const TriangleMesh& mesh, std::span<const EdgeUse> uses);

} // namespace brittle::fracture::mending
