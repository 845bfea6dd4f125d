// How much of the air a convex body meets: the area of its shadow, by direction.
//
// The shadow of a convex polyhedron along a unit vector u is half the sum of |a . u| over its faces, a being a face's outward
// normal times its area. Its mean over all directions is a quarter of the surface (Cauchy).
//
// Square metres, in the axes of the points. Thread-safe: no state.
//
//     CrossSection section = cross_section(hull.points);   // hull.h
//     float shadow = section.along({0.0f, 1.0f, 0.0f});
#pragma once

#include <array>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace brittle::physics {

struct CrossSection {
    std::vector<glm::vec3> sides{}; // the shadow along u is the sum of their |side . u|; none: not known

    [[nodiscard]] float along(const glm::vec3& direction) const; // a unit vector
    [[nodiscard]] float mean() const;                            // over all directions
};

// Of a closed convex surface by its faces: their area times their normal, of either sign.
[[nodiscard]] CrossSection section_of_faces(std::span<const glm::dvec3> areas);

// Of a box by its half sides along its own axes.
[[nodiscard]] CrossSection section_of_box(const glm::dvec3& half, const std::array<glm::dvec3, 3>& axes);

// With thirteen sides at most, one for each axis through faces, edges and corners of a cube: those that look along the same
// one become one. The mean stays, and so does the shadow of what has one side an axis; else it is off by a few per cent, a
// quarter at worst.
[[nodiscard]] CrossSection bundled(std::span<const glm::vec3> sides);

} // namespace brittle::physics
