// Verification of a fracture: counts, closedness, volumes and a hash, computed from the pieces alone.
//
//     const Certificate certificate = certify(mesh, fragments);
//     if (!certificate.closed) ...
#pragma once

#include <cstdint>

#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture {

// The largest Certificate::volume_error of a sound result. Rounding of coordinates stays far below it, except for
// meshes that are about as thin as the last digits of their coordinates; fracture() refuses these.
inline constexpr double max_volume_error = 1e-6;

// Checks the topology of every piece (topology.h) and computes all volumes anew, without trust in Piece::mass or in the
// indices. A piece with a range or an index outside its array counts as open, as does a piece without triangles; a
// result without pieces counts as closed. volume_error is absolute if the input has no volume. Linear time. The result
// is equal for any number of threads (0 means one per core).
//
// `closed` does not imply that pieces are disjoint. They overlap where the input does; see fracture().
[[nodiscard]] Certificate certify(const TriangleMesh& input, const Fragments& fragments, uint32_t threads = 0);

// Returns a hash of positions (as IEEE doubles, -0 as +0), triangles and pieces (site, ranges, exterior count), in
// order; equal on every machine. The scheme is FNV-1a on 64-bit words instead of bytes, at an eighth of the cost, with
// a shift that spreads the high bits. Not cryptographic.
[[nodiscard]] uint64_t hash(const Fragments& fragments);

} // namespace brittle::fracture
