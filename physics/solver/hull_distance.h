// Distance or overlap depth of two convex hulls, with the nearest points.
//
// GJK finds the distance. It starts with the nearest corners of the last call: in a heap they are nearly always nearest
// still, and two support queries confirm it. EPA finds the depth of an overlap. Both compute in double on corners that
// are rounded to float once, so every iteration sees equal hulls and GJK can end with a repeated corner.
//
// Metres. Margins are not included: subtract both from the distance. Pure functions; thread-safe.
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

// The pairs of corners that span the nearest points: the start of the next search.
struct NearestCorners {
    uint32_t count = 0; // 0: no start is known
    std::array<uint16_t, 4> first{}, second{};
};

struct HullDistance {
    float distance = 0.0f;              // m; negative: depth of the overlap; above the limit: a lower bound
    glm::vec3 normal{0.0f, 1.0f, 0.0f}; // unit, in the first hull's frame, from the second to the first
    // The nearest or deepest point of the second hull, in the first hull's frame; unset above the limit. The point of
    // the first hull is point + normal * distance.
    glm::vec3 point{0.0f};
};

// Returns the distance of two hulls; second_in_first is the second hull's frame in the first hull's. If the hulls are
// farther apart than `limit`, the normal is any direction along which they are. `corners` is read and updated.
// Precondition: at most 65,536 points a hull. Hulls whose Minkowski difference is flat have an overlap of depth 0.
[[nodiscard]] HullDistance hull_distance(const HullShape& first, const HullShape& second,
                                         const Transform& second_in_first, float limit, NearestCorners& corners);

} // namespace brittle::physics
