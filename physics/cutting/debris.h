// Which debris is retired when there is too much of it.
//
// Debris is a free piece that came off by a break, or a group of bonded pieces that came off and go together. In a
// structure without an anchor, a group with more than half of the structure's original pieces is no debris.
//
// Debris that has slept too long is retired. While there are too many pieces or vertices, more follows: invisible
// before visible, then by rising volume over age, so the small and old go before the large and young. Visible debris
// fades first; invisible debris is removed at once.
//
// Pure functions; PieceId breaks ties.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace brittle::physics {

// Names a piece of one Destruction; never reused there.
struct PieceId {
    uint32_t value = UINT32_MAX; // the default names none

    friend auto operator<=>(PieceId, PieceId) = default;
};

struct DebrisLimits {
    size_t max_pieces = 2000; // of all pieces of the Destruction, debris or not
    size_t max_vertices = 4'000'000;
    double sleep_seconds = 30.0; // infinity: sleeping debris stays
    double fade_seconds = 1.0;
};

struct Debris {
    PieceId id; // of a group, its first piece
    size_t pieces = 1;
    double volume = 0.0; // m^3
    double age = 0.0;    // s, since it came off
    double slept = 0.0;  // s, since it last moved
    size_t vertices = 0;
    bool visible = true;
};

// The candidates to retire, the slept first, then by the order above. `pieces` and `vertices` count all pieces that are
// not fading, candidates included.
[[nodiscard]] std::vector<PieceId> retire_debris(std::span<const Debris> candidates, size_t pieces, size_t vertices,
                                                 const DebrisLimits& limits);

} // namespace brittle::physics
