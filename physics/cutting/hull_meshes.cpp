#include "physics/cutting/hull_meshes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/base/threads.h"
#include "fracture/mesh/convex_hull.h"
#include "physics/cutting/convex_parts.h"

namespace brittle::physics {

namespace {

// Engines add collision margins of their own, so the hulls are hardly shrunk.
constexpr float min_margin = 0.001f;
// Corners that reach less beyond the hull of the others, as a part of its longest extent, are left out. Between such
// corners lie faces so narrow that engines in single precision take a wrong normal from them, and push pieces that
// touch apart at metres a second (Rapier 0.12).
constexpr float min_reach = 0.005f;

struct Plane {
    glm::vec3 normal{0.0f}; // unit
    float distance = 0.0f;
};

std::vector<Plane> planes_of(const fracture::TriangleMesh& mesh) {
    std::vector<Plane> planes;
    for (const fracture::Triangle& t : mesh.triangles) {
        const glm::dvec3 a = mesh.positions[t.x];
        const glm::dvec3 across = glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
        const double twice_area = glm::length(across);
        if (!(twice_area > 0.0)) continue;
        const glm::dvec3 normal = across / twice_area;
        planes.push_back({glm::vec3(normal), static_cast<float>(glm::dot(normal, a))});
    }
    return planes;
}

} // namespace

// Starts with four corners; the next one is always that which reaches farthest beyond the hull of those before it.
fracture::TriangleMesh plain_hull(std::span<const glm::vec3> points) {
    if (points.size() < 4) return {};
    glm::vec3 low = points.front(), high = low;
    for (const glm::vec3& p : points) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    const glm::vec3 extent = high - low;
    const float enough = min_reach * std::max({extent.x, extent.y, extent.z});
    const auto farthest = [&](auto&& measure) {
        return *std::max_element(points.begin(), points.end(),
                                 [&](const glm::vec3& a, const glm::vec3& b) { return measure(a) < measure(b); });
    };
    const glm::vec3 first = farthest([&](const glm::vec3& p) { return glm::length(p - (low + high) * 0.5f); });
    const glm::vec3 second = farthest([&](const glm::vec3& p) { return glm::length(p - first); });
    const glm::vec3 line = second - first;
    const glm::vec3 third = farthest([&](const glm::vec3& p) { return glm::length(glm::cross(p - first, line)); });
    const glm::vec3 across = glm::cross(third - first, line);
    const glm::vec3 fourth = farthest([&](const glm::vec3& p) { return std::abs(glm::dot(p - first, across)); });
    std::vector<glm::vec3> corners{first, second, third, fourth};
    while (true) {
        fracture::TriangleMesh mesh = fracture::convex_hull(corners);
        const std::vector<Plane> planes = planes_of(mesh);
        if (planes.empty()) return fracture::convex_hull(points);
        const auto reach = [&](const glm::vec3& p) {
            float most = 0.0f;
            for (const Plane& plane : planes) most = std::max(most, glm::dot(plane.normal, p) - plane.distance);
            return most;
        };
        const glm::vec3 next = farthest(reach);
        if (!(reach(next) > enough)) return mesh;
        corners.push_back(next);
    }
}

std::vector<fracture::TriangleMesh> hull_meshes(const fracture::Fragments& fragments, const fracture::Piece& piece,
                                                std::span<const HullPlane> planes, const HullMeshSettings& settings) {
    const glm::dvec3 centre = piece.mass.centre_of_mass;
    const HullSettings hull{.max_vertices = settings.max_vertices, .margin_fraction = min_margin, .planes = planes};
    std::vector<fracture::TriangleMesh> hulls;
    for (const BodyPart& part :
         convex_parts(fragments.positions_of(piece), fragments.triangles_of(piece), piece.mass.volume, centre,
                      {.max_parts = settings.max_parts, .hull = hull})) {
        fracture::TriangleMesh mesh = plain_hull(part.hull->points);
        for (glm::dvec3& p : mesh.positions) p += centre + glm::dvec3(part.offset);
        hulls.push_back(std::move(mesh));
    }
    return hulls;
}

std::vector<std::vector<fracture::TriangleMesh>> hull_meshes(const fracture::Fragments& fragments,
                                                             const HullMeshSettings& settings, uint32_t threads) {
    const std::vector<std::vector<HullPlane>> planes = contact_planes(fragments);
    std::vector<std::vector<fracture::TriangleMesh>> hulls(fragments.pieces.size());
    fracture::Threads pool(threads);
    pool.for_each(static_cast<uint32_t>(hulls.size()),
                  [&](uint32_t p) { hulls[p] = hull_meshes(fragments, fragments.pieces[p], planes[p], settings); });
    return hulls;
}

} // namespace brittle::physics
