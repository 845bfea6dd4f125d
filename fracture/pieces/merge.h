// Merges pieces: groups of sites, pieces that are too small, and sheets without volume.
//
// Two pieces are joined in two steps. First the caps between them are removed, triangle by triangle (vertex_point pairs
// the two sides). Then the remaining surfaces are sewn along the edges of the removed caps. Sewing follows the surface
// around each edge, so the result is closed and manifold however many pieces meet there. An input triangle whose parts
// are all reunited becomes one triangle again, without the points that the cuts had put on its sides.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture {

// The representative of a piece that is deleted without a successor.
inline constexpr uint32_t dropped = 0xffffffffu;

struct MergeRules {
    std::span<const uint32_t> group_of_site{}; // adjacent pieces whose sites share a group are merged; or empty
    double min_volume = 0.0;                   // m^3; smaller pieces join the neighbour with the largest contact
    std::span<const uint8_t> flat{};  // per piece: 1 for a piece without volume, which is below any minimum; or empty
    std::span<const uint8_t> small{}; // per piece: 1 for a piece that counts as below the minimum; or empty
};

// Returns, per piece, 1 for a piece without volume (is_flat() in mesh/islands.h); empty if there is none. `solid` is the box
// of the solid that was cut.
[[nodiscard]] std::vector<uint8_t> flat_pieces(const Fragments& fragments, const Box& solid);

// Returns the representative of each piece: within a group the piece with the lowest index, for a small piece the
// neighbour that absorbs it. Pieces are absorbed in ascending order of volume; among contacts of equal area the
// neighbour with the lower index is chosen. A small piece without neighbours remains; a flat piece without a neighbour
// that covers it is `dropped`. Time is O(n log n).
[[nodiscard]] std::vector<uint32_t> choose_mergers(const Fragments& fragments, const MergeRules& rules);

// Merges all pieces with the same representative into one piece, at the place of the representative and with its site,
// and deletes dropped pieces. Mass properties are computed anew. Bonds of one pair of pieces are united: areas add up,
// the normal is the area-weighted mean. Positions are unchanged, and triangle_source of a cap is updated to the site of
// the merged piece across. The fragments must come from Algorithm::exact.
//
// Degenerate input can leave several ways to sew surfaces that touch. Then two vertices of a piece may have one
// vertex_point. Where two edges would have the same ends, one of them is halved, possibly on one side of a cap only.
void merge_pieces(Fragments& fragments, std::span<const uint32_t> representative, Threads& threads);

} // namespace brittle::fracture
