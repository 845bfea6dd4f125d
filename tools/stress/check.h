// What is wrong with a fracture, by oracles that share no code with it.
#pragma once

#include <string>

#include "tools/stress/case.h"

namespace brittle::stress {

// Fractures the case and says what does not hold, or nothing. For pieces:
//  - every edge of a piece is used once in each direction, every vertex has one fan of triangles and is used;
//  - signed volumes (long double) sum to the input's within 1e-12 of its absolute volume, or
//    what rounding coordinates to double may do to it (eps x largest coordinate x area) where that is more; positions
//    rounded to float relative to the centre within 1e-6 or eps x size x area; Piece::mass agrees;
//  - caps of neighbours are the same triangles turned over, bit for bit, and equal points are at equal places;
//  - before pieces become one, vertices lie in the cell of their piece's site, up to rounding;
//  - one more run with another number of threads gives the same hash;
//  - generic cases of moderate cost: `sequential` fills the same cells with the same volumes and as many islands.
[[nodiscard]] std::string complaint(const Case& c);

} // namespace brittle::stress
