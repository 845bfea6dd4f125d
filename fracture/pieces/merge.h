// Pieces become one again: groups of sites, pieces that are too small, sheets without volume.
//
// Two pieces are joined by taking out the caps between them, triangle by triangle (vertex_point tells which
// are the two sides of one), and by sewing what is left along the edges where those caps were. Sewing follows
// the surface around each edge, so what comes out is closed and manifold however many pieces meet there.
// Triangles of the input all of whose parts come together are whole again, without the points that the cuts
// had put on their sides.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture {

// Marks a piece that goes altogether.
inline constexpr uint32_t dropped = 0xffffffffu;

struct MergeRules {
    std::span<const uint32_t> group_of_site; // pieces that touch and whose sites share a group are one; or empty
    double min_volume = 0.0;                 // m^3; smaller pieces join the neighbour with the largest contact
    std::span<const uint8_t> flat;           // pieces of no volume: as if below any minimum
};

// For each piece the one that it becomes part of: in a group the one with the lowest index, for a small piece
// the neighbour. The smallest choose first; among contacts of equal area the lower index wins. Small pieces
// without a neighbour stay, flat ones are dropped. O(n log n).
[[nodiscard]] std::vector<uint32_t> choose_mergers(const Fragments& fragments, const MergeRules& rules);

// Makes pieces of one representative one piece, in its place, with its site, and leaves out dropped ones.
// Mass properties are computed anew; contacts of one pair add up, the normal is their mean by area. Positions
// stay as they are, and triangle_source of a cap follows the piece across. The fragments come from
// Algorithm::exact.
//
// Only degenerate input shows that what touches may be sewn in more than one way: two vertices of a piece may
// then have one vertex_point, and where two edges would have the same ends one of them is halved, if need be
// on one side of a cap only.
void merge_pieces(Fragments& fragments, std::span<const uint32_t> representative, Threads& threads);

} // namespace brittle::fracture
