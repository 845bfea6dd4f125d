// Face and vertex normals ("Real Time Voronoi Fracturing of Polygon Meshes", eq. 1 and 2).
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// Eq. 1: the unit normal of the triangle, outward for a counter-clockwise one; zero for a zero-area triangle.
[[nodiscard]] glm::dvec3 face_normal(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

// Eq. 2: per vertex the normalised sum of the normals of the faces around it, weighted by the angle of each
// face at the vertex (Thuermer and Wuethrich 1998), which unlike the paper's plain mean does not depend on
// how a flat region is triangulated. Zero for a vertex without faces.
[[nodiscard]] std::vector<glm::dvec3> vertex_normals(const TriangleMesh& mesh);

} // namespace brittle::fracture
