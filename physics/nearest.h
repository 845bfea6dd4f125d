// Points of a surface that are nearest to a point.
#pragma once

#include <glm/vec3.hpp>

#include "fracture/mesh.h"

namespace brittle::physics {

// Of a triangle, without area too.
[[nodiscard]] glm::dvec3 nearest_on_triangle(const glm::dvec3& point, const glm::dvec3& a, const glm::dvec3& b,
                                             const glm::dvec3& c);
// Of a mesh's surface; the point itself for a mesh without triangles. All triangles are looked at.
[[nodiscard]] glm::dvec3 nearest_on(const fracture::TriangleMesh& mesh, const glm::dvec3& point);

} // namespace brittle::physics
