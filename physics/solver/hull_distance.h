// How far apart two convex hulls are, or how deep they overlap, and where.
//
// GJK, which begins with the corners that were nearest last time: in a heap they nearly always still are, and two supports
// (HullShape::farthest, four points at a time) say so. Where hulls overlap, EPA. Both in double, on corners that are rounded
// once: the hulls that are compared are the same in each iteration, so the end is a corner that comes again, not a
// tolerance.
//
// Bullet's units. Margins are left out: subtract both from the distance. Thread-safe: no state.
//
// E. Gilbert, D. Johnson, S. Keerthi, "A fast procedure for computing the distance between complex objects", 1988;
// G. van den Bergen, "Proximity queries and penetration depth computation on 3D game objects", 2001 (EPA);
// C. Ericson, "Real-Time Collision Detection", 2004, 5.1 (nearest points of triangle and tetrahedron).
#pragma once

#include <array>
#include <cstdint>

#include <btBulletDynamicsCommon.h>

#include "physics/solver/hull_shape.h"

namespace brittle::physics {

// Pairs of corners that were nearest: where to begin the next time.
struct NearCorners {
    uint32_t count = 0; // 0: nothing is known
    std::array<uint16_t, 4> first{}, second{};
};

struct HullDistance {
    btScalar distance = 0.0f;           // below 0: how deep they overlap. Above the limit: at least so much
    btVector3 normal{0.0f, 1.0f, 0.0f}; // unit, in the first's axes, from the second to the first
    // Nearest, or deepest, on the second, in the first's frame; not known above the limit. The one on the first is
    // point + normal * distance.
    btVector3 point{0.0f, 0.0f, 0.0f};
};

// The second hull has its frame in that of the first. Beyond the limit any normal that separates them by more will do. Hulls
// have up to 65,536 points each, not all in one plane; where they are, an overlap may be told as one of depth 0.
[[nodiscard]] HullDistance hull_distance(const HullShape& first, const HullShape& second,
                                         const btTransform& second_in_first, btScalar limit, NearCorners& corners);

} // namespace brittle::physics
