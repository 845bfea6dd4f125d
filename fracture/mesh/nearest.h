// The points of a triangle and of a mesh surface that are nearest to a query point, and the distance to a convex hull.
//
// Any unit of length. Pure functions; thread-safe. Cost is linear in triangles or hull points.
//
//     glm::dvec3 on_surface = nearest_on(mesh, point);
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// Returns the point of triangle (a, b, c) that is nearest to `point`. A triangle without area counts as its edges.
[[nodiscard]] glm::dvec3 nearest_on_triangle(const glm::dvec3& point, const glm::dvec3& a, const glm::dvec3& b,
                                             const glm::dvec3& c);

// Returns the point of the mesh's surface that is nearest to `point`, the first one of equally near triangles. A mesh
// without triangles gives `point` itself. Tests every triangle.
[[nodiscard]] glm::dvec3 nearest_on(const TriangleMesh& mesh, const glm::dvec3& point);

// Returns the distance from `point` to the convex hull of at least one point, 0 inside it. The relative error is at most
// 1e-3; below a distance of 1e-3 times the farthest point's, the absolute error is of that size. Pairwise Frank-Wolfe
// steps move weight from one hull point to another (Lacoste-Julien and Jaggi, "On the Global Linear Convergence of
// Frank-Wolfe Optimization Variants", 2015).
[[nodiscard]] double distance_to_hull(std::span<const glm::vec3> points, const glm::dvec3& point);

} // namespace brittle::fracture
