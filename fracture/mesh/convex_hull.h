// The convex hull of points, by exact predicates, without tolerances.
//
//     const TriangleMesh hull = convex_hull(points);
//     const double volume = signed_volume(hull.positions, hull.triangles);
//
// Quickhull (Barber, Dobkin and Huhdanpaa, "The Quickhull Algorithm for Convex Hulls", 1996). Every side that a point is
// found to lie on is the true one, so that coplanar and nearly coplanar points need no merging of faces.
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// Returns the hull as a closed mesh whose triangles have area and are counter-clockwise seen from outside. Its vertices
// are some of the points, in their order: all corners of the hull, once each, and perhaps points on its faces. Returns
// an empty mesh for points in one plane, and where a coordinate is neither zero nor, by magnitude, from 1e-70 to 1e50:
// products of three would overflow or underflow. Those of points in single precision are in this range if finite.
[[nodiscard]] TriangleMesh convex_hull(std::span<const glm::dvec3> points);
// Points in single precision take less time: fewer of them lie in a plane so nearly that only exact arithmetic decides.
[[nodiscard]] TriangleMesh convex_hull(std::span<const glm::vec3> points);

} // namespace brittle::fracture
