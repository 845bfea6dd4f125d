// The cross section of a convex body for air drag: the area of its shadow by direction.
//
// The shadow of a convex polyhedron along a unit vector u is half the sum of |a . u| over its faces, where a is a
// face's outward normal times its area. Its mean over all directions is a quarter of the surface (Cauchy).
//
// Square metres, in the axes of the points. Pure functions; thread-safe.
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
    std::vector<glm::vec3> sides{}; // m^2; the shadow along u is the sum of |side . u|; empty: unknown

    [[nodiscard]] float along(const glm::vec3& direction) const; // m^2; a unit vector
    [[nodiscard]] float mean() const;                            // m^2, over all directions
};

// Returns the cross section of a closed convex surface from its faces' normals times areas, of either sign.
[[nodiscard]] CrossSection section_of_faces(std::span<const glm::dvec3> areas);

// Returns the cross section of a box from its half extents along its own axes.
[[nodiscard]] CrossSection section_of_box(const glm::dvec3& half, const std::array<glm::dvec3, 3>& axes);

// Reduces sides to at most thirteen, one for each axis through the faces, edges and corners of a cube: the sides
// nearest to one axis are summed. The mean is preserved exactly. The shadow is exact if no two sides share an axis;
// otherwise its error is a few per cent, a quarter at worst.
[[nodiscard]] CrossSection reduced(std::span<const glm::vec3> sides);

} // namespace brittle::physics
