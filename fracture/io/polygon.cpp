#include "fracture/io/polygon.h"

#include <vector>

#include <glm/geometric.hpp>

#include "fracture/triangulate.h"

namespace brittle::fracture {

namespace {

// The first diagonal where both would do or the quad is folded.
void append_quad(TriangleMesh& mesh, std::span<const uint32_t> face) {
    const auto normal = [&](size_t a, size_t b, size_t c) {
        const glm::dvec3& origin = mesh.positions[face[a]];
        return glm::cross(mesh.positions[face[b]] - origin, mesh.positions[face[c]] - origin);
    };
    const bool first_works = glm::dot(normal(0, 1, 2), normal(0, 2, 3)) > 0.0;
    const bool second_works = glm::dot(normal(1, 2, 3), normal(1, 3, 0)) > 0.0;
    const size_t start = !first_works && second_works ? 1 : 0;
    mesh.triangles.emplace_back(face[start], face[start + 1], face[start + 2]);
    mesh.triangles.emplace_back(face[start], face[start + 2], face[(start + 3) % 4]);
}

} // namespace

void append_polygon(TriangleMesh& mesh, std::span<const uint32_t> face) {
    if (face.size() == 3) {
        mesh.triangles.emplace_back(face[0], face[1], face[2]);
        return;
    }
    if (face.size() == 4) return append_quad(mesh, face);
    // Newell's normal: right for concave and slightly bent polygons too.
    const glm::dvec3 origin = mesh.positions[face[0]];
    glm::dvec3 normal{0.0};
    for (size_t k = 1; k + 1 < face.size(); ++k)
        normal += glm::cross(mesh.positions[face[k]] - origin, mesh.positions[face[k + 1]] - origin);
    std::vector<glm::dvec2> points;
    std::vector<Loop> loop(1);
    for (const uint32_t corner : face) {
        loop[0].push_back(static_cast<uint32_t>(points.size()));
        points.push_back(project(mesh.positions[corner] - origin, normal));
    }
    for (const Triangle& t : triangulate(points, loop).triangles)
        mesh.triangles.emplace_back(face[t.x], face[t.y], face[t.z]);
}

} // namespace brittle::fracture
