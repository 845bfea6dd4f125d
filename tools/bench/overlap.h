// How far convex hulls reach into each other, by separating axes in double precision: an oracle that shares nothing
// with the solver's contacts.
//
// The axes are all face normals and all cross products of two edges. Between two overlapping hulls the least overlap
// along an axis is the penetration depth, exactly. Between two that are apart, the greatest gap is at most their
// distance. A hull's margin rounds it, so depth = both margins + depth of the cores: exact where a face or two edges
// face each other, too large where the nearest features are a corner and a corner or an edge.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "physics/world/world.h"

namespace brittle::tools {

// The features of a hull, in body axes.
struct HullFeatures {
    std::vector<glm::dvec3> points{};
    std::vector<glm::dvec3> normals{}; // of faces, unit
    std::vector<double> offsets{};     // of the faces' planes: inside is normal . x <= offset; margin included
    std::vector<glm::dvec3> edges{};   // directions, unit
    double margin = 0.0;               // m
    double radius = 0.0;               // m, of the farthest point, margin included
    double volume = 0.0;               // m^3, without the margin
};
[[nodiscard]] HullFeatures features_of(const physics::CollisionHull& hull);

// Returns the depth, m, to which two hulls overlap; negative: the gap.
[[nodiscard]] double overlap(const HullFeatures& a, const physics::Pose& pose_a, const HullFeatures& b,
                             const physics::Pose& pose_b);

// Returns the depths of all pairs that overlap, m. Hulls and poses are by body.
[[nodiscard]] std::vector<double> overlaps(std::span<const HullFeatures> hulls, std::span<const physics::Pose> poses);

// Returns for each hull the largest share of its volume, 0 to 1, that lies inside another hull that is at least as large:
// by 64 points inside it, to within about a twentieth.
[[nodiscard]] std::vector<double> shares_inside(std::span<const HullFeatures> hulls,
                                                std::span<const physics::Pose> poses);

} // namespace brittle::tools
