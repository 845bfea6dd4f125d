// One piece out of several: takes out the caps between them and sews what is left. See merge.h.
#pragma once

#include <cstdint>
#include <span>

#include "fracture/pieces/cap_pairs.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture {

// What the sewing of all sets has in common.
struct SewingPlan {
    const Fragments& fragments;
    std::span<const uint32_t> representative;  // of each piece, see choose_mergers()
    const CapPairs& caps;                      // of all sites that have a piece which changes
    std::span<const uint32_t> parts_of_source; // of how many exterior triangles each input triangle is the source
};

// Appends the union of the pieces, which ascend, to `out` and returns it without site and mass. Its new
// points, if it needs any, are numbered from next_point on, at most three for each triangle of the pieces.
[[nodiscard]] Piece sew_pieces(const SewingPlan& plan, std::span<const uint32_t> pieces, uint32_t next_point,
                               Fragments& out);

} // namespace brittle::fracture
