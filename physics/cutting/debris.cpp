#include "physics/cutting/debris.h"

#include <algorithm>
#include <tuple>

namespace brittle::physics {

std::vector<PieceId> retire_debris(std::span<const Debris> candidates, size_t pieces, size_t vertices,
                                   const DebrisLimits& limits) {
    std::vector<PieceId> gone;
    std::vector<const Debris*> staying;
    const auto take = [&](const Debris& debris) {
        gone.push_back(debris.id);
        pieces -= debris.pieces;
        vertices -= debris.vertices;
    };
    for (const Debris& debris : candidates) {
        if (debris.slept > limits.sleep_seconds)
            take(debris);
        else
            staying.push_back(&debris);
    }
    const auto too_many = [&] { return pieces > limits.max_pieces || vertices > limits.max_vertices; };
    if (!too_many()) return gone;
    constexpr double newborn = 0.1; // s, added to the age, so that size alone decides at birth
    std::ranges::sort(staying, [](const Debris* a, const Debris* b) {
        const double size_a = a->volume / (a->age + newborn), size_b = b->volume / (b->age + newborn);
        return std::tuple(a->visible, size_a, a->id) < std::tuple(b->visible, size_b, b->id);
    });
    for (const Debris* debris : staying) {
        if (!too_many()) break;
        take(*debris);
    }
    return gone;
}

} // namespace brittle::physics
