// Builds the union of several pieces: removes the caps between them and sews the remaining surfaces. See merge.h.
#pragma once

#include <cstdint>
#include <span>

#include "fracture/pieces/cap_pairs.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture {

// The inputs that all unions of one merge share.
struct SewingPlan {
    const Fragments& fragments;
    std::span<const uint32_t> representative; // per piece, see choose_mergers()
    const CapPairs& caps;                     // pairs of all caps of sites with a changed piece
    // Per input triangle, the count of exterior triangles that come from it.
    std::span<const uint32_t> parts_of_source;
};

// Appends the union of the pieces to `out` and returns it, without site and mass. Precondition: the piece indices
// ascend. New points, if any, are numbered from next_point on, at most three per triangle of the pieces.
[[nodiscard]] Piece sew_pieces(const SewingPlan& plan, std::span<const uint32_t> pieces, uint32_t next_point,
                               Fragments& out);

} // namespace brittle::fracture
