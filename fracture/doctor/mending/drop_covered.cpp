#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "fracture/doctor/mending/steps.h"
#include "fracture/mesh/intersections.h"
#include "fracture/mesh/islands.h"
#include "fracture/mesh/topology.h"

namespace brittle::fracture::mending {
namespace {

// The maximum number of parts: each is compared with all triangles of the others.
constexpr size_t max_parts = 1000;
constexpr uint64_t max_pairs = 10'000'000; // see InspectSettings

struct Part {
    std::vector<Triangle> triangles;
    uint32_t first = no_index; // the first triangle
    double volume = 0.0;
    bool crosses = false;
    glm::dvec3 place{0.0}; // a point on it, inside a triangle
};

std::vector<Part> find_parts(const TriangleMesh& mesh, const std::vector<uint32_t>& part_of) {
    std::vector<Part> parts;
    for (uint32_t t = 0; t < part_of.size(); ++t) {
        if (part_of[t] == parts.size()) parts.emplace_back().first = t;
        parts[part_of[t]].triangles.push_back(mesh.triangles[t]);
    }
    for (Part& part : parts) {
        part.volume = signed_volume(mesh.positions, part.triangles);
        double largest = -1.0;
        for (const Triangle& t : part.triangles) {
            const glm::dvec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
            const double area = glm::length(glm::cross(b - a, c - a));
            if (!(area > largest)) continue;
            largest = area;
            part.place = (a + b + c) / 3.0;
        }
    }
    return parts;
}

} // namespace

bool drop_covered(Work& work) {
    const TriangleMesh& mesh = work.mesh;
    if (!check_topology(mesh.positions.size(), mesh.triangles).closed()) return false;
    const std::vector<uint32_t> part_of = triangle_components(mesh.positions.size(), mesh.triangles);
    std::vector<Part> parts = find_parts(mesh, part_of);
    if (parts.size() < 2 || parts.size() > max_parts) return false;
    const Intersections crossings = find_intersections(mesh, max_pairs, max_pairs);
    for (const glm::uvec2& pair : crossings.listed) {
        if (part_of[pair.x] == part_of[pair.y]) continue;
        parts[part_of[pair.x]].crosses = parts[part_of[pair.y]].crosses = true;
    }
    if (!crossings.complete) return false;

    std::vector<uint8_t> covered(parts.size(), 0);
    for (size_t k = 0; k < parts.size(); ++k) {
        if (parts[k].crosses) continue;
        double around = 0.0; // winding number of the other parts, constant on this part
        for (size_t other = 0; other < parts.size(); ++other)
            if (other != k) around += winding_number(parts[k].place, mesh.positions, parts[other].triangles);
        const double outside = std::round(around), inside = outside + (parts[k].volume < 0.0 ? -1.0 : 1.0);
        covered[k] = (outside > 0.0) == (inside > 0.0) ? 1 : 0;
        if (covered[k]) work.report.covered_parts.add(work.source[parts[k].first]);
    }
    if (std::count(covered.begin(), covered.end(), 1) == 0) return false;
    std::vector<uint8_t> gone(part_of.size());
    for (uint32_t t = 0; t < part_of.size(); ++t) gone[t] = covered[part_of[t]];
    work.drop(gone);
    return true;
}

} // namespace brittle::fracture::mending
