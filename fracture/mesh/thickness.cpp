#include "fracture/mesh/thickness.h"

#include <numeric>

#include <glm/geometric.hpp>

namespace brittle::fracture {

namespace {

std::vector<uint32_t> all_of(const TriangleMesh& mesh) {
    std::vector<uint32_t> triangles(mesh.triangles.size());
    std::iota(triangles.begin(), triangles.end(), 0u);
    return triangles;
}

} // namespace

Thickness::Thickness(const TriangleMesh& mesh) : mesh_(mesh), tree_(mesh, all_of(mesh)) {}

glm::dvec3 Thickness::inward(uint32_t triangle) const {
    const Triangle& t = mesh_.triangles[triangle];
    const glm::dvec3& a = mesh_.positions[t.x];
    const glm::dvec3 normal = glm::cross(mesh_.positions[t.z] - a, mesh_.positions[t.y] - a);
    const double length = glm::length(normal);
    return length > 0.0 ? normal / length : glm::dvec3(0.0);
}

std::optional<double> Thickness::at(uint32_t triangle, const glm::dvec3& point, uint64_t* visits) const {
    const glm::dvec3 direction = inward(triangle);
    if (direction == glm::dvec3(0.0)) return std::nullopt;
    return tree_.first_hit(point, direction, triangle, visits);
}

} // namespace brittle::fracture
