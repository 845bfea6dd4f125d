// The proof that comes with a fracture: counts, closedness, volumes and a hash, computed from the pieces
// alone.
#pragma once

#include <cstdint>

#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture {

// Checks every piece's topology (topology.h) and sums up volumes anew, trusting neither Piece::mass nor the
// indices: a piece whose ranges or indices point outside their arrays counts as open, as does one without
// triangles. volume_error is absolute where the input has no volume. No piece at all counts as closed. Linear
// time; equal for any number of threads (0 = one a core).
//
// What `closed` does not say: that pieces do not overlap. They overlap where the input does, and have negative
// volume where it is inside out (smallest_piece < 0); see fracture().
[[nodiscard]] Certificate certify(const TriangleMesh& input, const Fragments& fragments, uint32_t threads = 0);

// A hash of positions (as IEEE doubles, -0 as +0), triangles and pieces (site, ranges, exterior count), in
// order; the same on every machine. FNV-1a's scheme on 64-bit words instead of bytes, which costs an eighth,
// with a shift that spreads high bits. Not cryptographic.
[[nodiscard]] uint64_t hash(const Fragments& fragments);

} // namespace brittle::fracture
