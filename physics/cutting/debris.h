// Which debris goes when there is too much of it.
//
// Debris is what came off by a break and is held by nothing: a piece, or several that are bonded, which go together. Of bonded
// pieces without an anchor what has more than half of those that it began with is none: it is what the others came off.
// What has slept too long goes; and while there are too many
// pieces or vertices, what no one sees goes before what is seen, then what is small and old before what is large
// and young: by volume over age, since it came off. What is seen fades first; the rest goes at once.
//
// Pure functions; ties are broken by PieceId.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace brittle::physics {

// Names a piece of one Destruction; never used again there.
struct PieceId {
    uint32_t value = UINT32_MAX; // the default names none

    friend auto operator<=>(PieceId, PieceId) = default;
};

struct DebrisLimits {
    size_t max_pieces = 2000; // in the world, debris or not
    size_t max_vertices = 4'000'000;
    double sleep_seconds = 30.0; // s; infinity: debris may sleep for ever
    double fade_seconds = 1.0;   // s
};

struct Debris {
    PieceId id; // of several the first
    size_t pieces = 1;
    double volume = 0.0; // m^3
    double age = 0.0;    // s
    double slept = 0.0;  // s, since it last moved
    size_t vertices = 0;
    bool visible = true;
};

// Those of candidates that must go; pieces and vertices are those of all that stays, candidates among them.
[[nodiscard]] std::vector<PieceId> retire_debris(std::span<const Debris> candidates, size_t pieces, size_t vertices,
                                                 const DebrisLimits& limits);

} // namespace brittle::physics
