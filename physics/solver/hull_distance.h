// How far apart two convex hulls are, or how deep they overlap, and where.
//
// GJK, started with the corners that were nearest last time: in a heap they nearly always still are, and two support
// queries confirm it. For hulls that overlap, EPA. Both in double, on corners that are rounded once: every iteration
// compares the same hulls, so the search ends with a corner that repeats, not with a tolerance.
//
// Metres. Margins are left out: subtract both from the distance. Thread-safe: no state.
//
// E. Gilbert, D. Johnson, S. Keerthi, "A fast procedure for computing the distance between complex objects", 1988;
// G. van den Bergen, "Proximity queries and penetration depth computation on 3D game objects", 2001 (EPA);
// C. Ericson, "Real-Time Collision Detection", 2004, 5.1 (nearest points of triangle and tetrahedron).
#pragma once

#include <array>
#include <cstdint>

#include <glm/vec3.hpp>

#include "physics/solver/hull_shape.h"

namespace brittle::physics {

// The pairs of corners that span the nearest points: where the next search begins.
struct NearestCorners {
    uint32_t count = 0; // 0: none are known
    std::array<uint16_t, 4> first{}, second{};
};

struct HullDistance {
    float distance = 0.0f;              // below 0: the depth of the overlap; above the limit: a lower bound
    glm::vec3 normal{0.0f, 1.0f, 0.0f}; // unit, in the first hull's frame, from the second to the first
    // The nearest or deepest point of the second hull, in the first one's frame; unset above the limit. The one of
    // the first hull is point + normal * distance.
    glm::vec3 point{0.0f};
};

// Takes the second hull's frame in that of the first. Beyond the limit any normal that separates the hulls by more is
// returned. Hulls have up to 65,536 points each, not all in one plane; flat ones may have an overlap of depth 0.
[[nodiscard]] HullDistance hull_distance(const HullShape& first, const HullShape& second,
                                         const Transform& second_in_first, float limit, NearestCorners& corners);

} // namespace brittle::physics
