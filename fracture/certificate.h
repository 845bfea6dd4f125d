// The proof that comes with a fracture: counts, closedness, volumes and a hash, computed from the pieces alone.
#pragma once

#include "fracture/fragments.h"
#include "fracture/mesh.h"

namespace brittle::fracture {

// Checks every piece's topology (topology.h) and sums up. Linear time.
[[nodiscard]] Certificate certify(const TriangleMesh& input, const Fragments& fragments);

// FNV-1a over the bytes of positions (as IEEE doubles, -0 as +0), triangles and piece ranges, in order.
[[nodiscard]] uint64_t hash(const Fragments& fragments);

} // namespace brittle::fracture
