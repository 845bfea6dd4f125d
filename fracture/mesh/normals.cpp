#include "fracture/mesh/normals.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace brittle::fracture {
namespace {

// The vector at length one; zero stays zero. Scaled first, so that tiny and huge vectors keep their
// direction.
glm::dvec3 unit_or_zero(const glm::dvec3& v) {
    const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    if (!(largest > 0.0) || !std::isfinite(largest)) return glm::dvec3(0.0);
    return glm::normalize(v / largest);
}

// Exact to rounding for every angle, where an arc cosine loses half the digits near 0 and 180 degrees.
double angle_between(const glm::dvec3& u, const glm::dvec3& v) {
    return std::atan2(length(cross(u, v)), dot(u, v));
}

} // namespace

glm::dvec3 face_normal(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const glm::dvec3 u = b - a, v = c - a;
    const glm::dvec3 size = glm::max(glm::abs(u), glm::abs(v));
    const double largest = std::max({size.x, size.y, size.z});
    if (!(largest > 0.0)) return glm::dvec3(0.0);
    return unit_or_zero(cross(u / largest, v / largest)); // scaled: 1e-200 squared would be zero
}

std::vector<glm::dvec3> vertex_normals(const TriangleMesh& mesh) {
    std::vector<glm::dvec3> normals(mesh.positions.size(), glm::dvec3(0.0));
    for (const Triangle& t : mesh.triangles) {
        const glm::dvec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
        const glm::dvec3 normal = face_normal(a, b, c);
        const glm::dvec3 ab = unit_or_zero(b - a), bc = unit_or_zero(c - b), ca = unit_or_zero(a - c);
        normals[t.x] += normal * angle_between(ab, -ca);
        normals[t.y] += normal * angle_between(bc, -ab);
        normals[t.z] += normal * angle_between(ca, -bc);
    }
    for (glm::dvec3& n : normals) n = unit_or_zero(n);
    return normals;
}

} // namespace brittle::fracture
