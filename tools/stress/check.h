// Checks of a fracture by oracles that share no code with it.
#pragma once

#include <string>

#include "tools/stress/case.h"

namespace brittle::stress {

// Unites the mesh (check_union.h), fractures the case and returns the first check that fails, or an empty string. For pieces:
//  - every edge of a piece is used once in each direction, every vertex has one fan of triangles and is used;
//  - signed volumes (in long double) sum to the input's, within the larger of 1e-12 of its absolute volume and the
//    error of rounding coordinates to double (eps x largest coordinate x area); for positions rounded to float relative
//    to the centre, within 1e-6 or eps x size x area; Piece::mass agrees;
//  - caps of neighbours are equal triangles of opposite orientation, bit for bit; equal points have equal positions;
//  - before pieces merge, vertices lie in the cell of their piece's site, up to rounding;
//  - a run with another number of threads gives an equal hash;
//  - with rough cuts pieces are closed, volumes and caps agree, and no piece of a simple mesh crosses itself uncounted;
//  - the cut of a small part agrees with that of the whole (check_local.h);
//  - in generic cases of moderate cost, `sequential` fills the same cells, with equal volumes and numbers of islands.
[[nodiscard]] std::string complaint(const Case& c);

} // namespace brittle::stress
