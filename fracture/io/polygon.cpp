#include "fracture/io/polygon.h"

#include <glm/geometric.hpp>

#include "fracture/triangulation/triangulate.h"

namespace brittle::fracture {

namespace {

// The budget of vertex tests per file, at about a nanosecond each. Simple polygons need a dozen per corner.
constexpr uint64_t free_tests = 100'000'000;
constexpr uint64_t tests_per_corner = 100;

} // namespace

std::optional<std::span<const Triangle>> PolygonSplitter::split(std::span<const glm::dvec3> positions,
                                                                std::span<const uint32_t> corners) {
    triangles_.clear();
    if (corners.size() == 3)
        triangles_.emplace_back(0, 1, 2);
    else if (corners.size() == 4)
        split_quad(positions, corners);
    else
        split_large(positions, corners);
    if (tests_ > free_tests + tests_per_corner * corners_) return std::nullopt;
    return triangles_;
}

// Takes the first diagonal where both are possible or the quad is folded.
void PolygonSplitter::split_quad(std::span<const glm::dvec3> positions, std::span<const uint32_t> corners) {
    const auto normal = [&](size_t a, size_t b, size_t c) {
        const glm::dvec3& origin = positions[corners[a]];
        return glm::cross(positions[corners[b]] - origin, positions[corners[c]] - origin);
    };
    const bool first_works = glm::dot(normal(0, 1, 2), normal(0, 2, 3)) > 0.0;
    const bool second_works = glm::dot(normal(1, 2, 3), normal(1, 3, 0)) > 0.0;
    const uint32_t start = !first_works && second_works ? 1 : 0;
    triangles_.emplace_back(start, start + 1, start + 2);
    triangles_.emplace_back(start, start + 2, (start + 3) % 4);
}

void PolygonSplitter::split_large(std::span<const glm::dvec3> positions, std::span<const uint32_t> corners) {
    // Newell's normal, valid for concave and slightly bent polygons too.
    const glm::dvec3 origin = positions[corners[0]];
    glm::dvec3 normal{0.0};
    for (size_t k = 1; k + 1 < corners.size(); ++k)
        normal += glm::cross(positions[corners[k]] - origin, positions[corners[k + 1]] - origin);
    std::vector<glm::dvec2> points;
    std::vector<Loop> loop(1);
    for (const uint32_t corner : corners) {
        loop[0].push_back(static_cast<uint32_t>(points.size()));
        points.push_back(project(positions[corner] - origin, normal));
    }
    Triangulation made = triangulate(points, loop);
    triangles_ = std::move(made.triangles);
    corners_ += corners.size();
    tests_ += made.vertex_tests;
}

} // namespace brittle::fracture
