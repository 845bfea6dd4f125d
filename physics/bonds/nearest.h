// Points of a surface, and the hull, that are nearest to a point.
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::physics {

// Of a triangle, without area too.
[[nodiscard]] glm::dvec3 nearest_on_triangle(const glm::dvec3& point, const glm::dvec3& a, const glm::dvec3& b,
                                             const glm::dvec3& c);
// Of a mesh's surface; the point itself for a mesh without triangles. All triangles are looked at.
[[nodiscard]] glm::dvec3 nearest_on(const fracture::TriangleMesh& mesh, const glm::dvec3& point);
// To the convex hull of points, at least one, to a thousandth of their distances from the point: 0 inside of it. By
// Frank-Wolfe steps that move weight from one corner to another (Lacoste-Julien and Jaggi, "On the Global Linear
// Convergence of Frank-Wolfe Optimization Variants", 2015): microseconds for a hull of 32.
[[nodiscard]] double distance_to_hull(std::span<const glm::vec3> points, const glm::dvec3& point);

} // namespace brittle::physics
