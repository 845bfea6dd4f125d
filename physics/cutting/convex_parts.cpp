#include "physics/cutting/convex_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/mesh/convex_hull.h"
#include "fracture/mesh/mass_properties.h"
#include "physics/cutting/impact_pattern.h"

namespace brittle::physics {

namespace {

using fracture::Fragments;
using fracture::Triangle;
using fracture::TriangleMesh;

constexpr size_t max_exact_points = 500; // up to this number, all are candidates
constexpr int directions_a_side = 10;    // bins along the side of a cube
constexpr int settling_rounds = 3;       // of Lloyd's relaxation of the two sites

struct Part {
    TriangleMesh mesh;              // of the uncut solid empty until its first cut
    std::vector<glm::dvec3> points; // candidates for its hull
    double volume = 0.0;
    double excess = 0.0; // m^3, empty volume of the hull
    bool final = false;  // a cut failed
};

glm::dvec3 middle_of(std::span<const glm::dvec3> points) {
    if (points.empty()) return glm::dvec3(0.0);
    glm::dvec3 low = points[0], high = points[0];
    for (const glm::dvec3& p : points) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    return (low + high) * 0.5;
}

Part part_of(std::span<const glm::dvec3> positions, double volume) {
    Part part;
    part.points = hull_candidates(positions);
    part.volume = volume;
    // Measures the exact hull. A collision hull has a bounded number of vertices and a margin, and may be smaller than
    // the solid; only parts that are cut no more get one.
    const std::vector<glm::vec3> corners(part.points.begin(), part.points.end());
    const TriangleMesh full = fracture::convex_hull(corners);
    part.excess = fracture::signed_volume(full.positions, full.triangles) - volume;
    return part;
}

// Two sites at the centres of two halves of the surface: the farthest pair of vertices, relaxed.
std::array<glm::dvec3, 2> two_sites(const TriangleMesh& mesh) {
    const std::vector<glm::dvec3> ends = spread_points(mesh.positions, 2, std::array{middle_of(mesh.positions)});
    if (ends.size() < 2) return {};
    struct Mass {
        glm::dvec3 centre;
        double area; // twice
    };
    std::vector<Mass> masses; // of the triangles
    masses.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) {
        const glm::dvec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
        masses.push_back({(a + b + c) / 3.0, glm::length(glm::cross(b - a, c - a))});
    }
    std::array<glm::dvec3, 2> sites{ends[0], ends[1]};
    for (int round = 0; round < settling_rounds; ++round) {
        std::array<glm::dvec3, 2> sum{glm::dvec3(0.0), glm::dvec3(0.0)};
        std::array<double, 2> weight{};
        for (const auto& [centre, area] : masses) {
            const glm::dvec3 to_first = centre - sites[0], to_second = centre - sites[1];
            const size_t nearer = glm::dot(to_first, to_first) <= glm::dot(to_second, to_second) ? 0 : 1;
            sum[nearer] += area * centre;
            weight[nearer] += area;
        }
        for (size_t k = 0; k < 2; ++k)
            if (weight[k] > 0.0) sites[k] = sum[k] / weight[k];
    }
    return sites;
}

// The parts on both sides of the bisector; empty if the cut fails.
std::vector<Part> cut(const TriangleMesh& mesh, fracture::Workspace& workspace, Fragments& scratch) {
    std::vector<Part> parts;
    const std::array<glm::dvec3, 2> sites = two_sites(mesh);
    const fracture::Result<void> done = fracture::fracture(mesh, sites, {.threads = 1}, workspace, scratch);
    if (!done || scratch.pieces.size() < 2) return parts;
    for (const fracture::Piece& piece : scratch.pieces) {
        const auto positions = scratch.positions_of(piece);
        const auto triangles = scratch.triangles_of(piece);
        Part part = part_of(positions, piece.mass.volume);
        part.mesh = {{positions.begin(), positions.end()}, {triangles.begin(), triangles.end()}};
        parts.push_back(std::move(part));
    }
    return parts;
}

} // namespace

std::vector<glm::dvec3> hull_candidates(std::span<const glm::dvec3> points) {
    if (points.size() <= max_exact_points) return {points.begin(), points.end()};
    const glm::dvec3 middle = middle_of(points);
    struct Farthest {
        double square = -1.0;
        size_t point = 0;
    };
    std::vector<Farthest> farthest(6 * directions_a_side * directions_a_side);
    const auto bin = [](double at) {
        return std::clamp(static_cast<int>((at + 1.0) * 0.5 * directions_a_side), 0, directions_a_side - 1);
    };
    for (size_t i = 0; i < points.size(); ++i) {
        const glm::dvec3 arm = points[i] - middle, size = glm::abs(arm);
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        if (!(size[axis] > 0.0)) continue;
        const int side = 2 * axis + (arm[axis] > 0.0 ? 1 : 0);
        const int u = bin(arm[(axis + 1) % 3] / size[axis]), v = bin(arm[(axis + 2) % 3] / size[axis]);
        Farthest& known = farthest[static_cast<size_t>((side * directions_a_side + u) * directions_a_side + v)];
        if (const double square = glm::dot(arm, arm); square > known.square) known = {square, i};
    }
    std::vector<glm::dvec3> kept;
    for (const Farthest& f : farthest)
        if (f.square >= 0.0) kept.push_back(points[f.point]);
    return kept;
}

std::vector<BodyPart> convex_parts(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
                                   double volume, const glm::dvec3& origin, const ConvexPartSettings& settings) {
    std::vector<Part> parts;
    parts.push_back(part_of(settings.points.empty() ? positions : settings.points, volume));
    fracture::Workspace workspace;
    Fragments scratch;
    while (parts.size() < settings.max_parts) {
        Part* worst = nullptr;
        for (Part& part : parts) {
            const bool empty = part.excess > settings.max_empty * (part.excess + part.volume)
                               && part.excess > settings.min_excess * volume;
            if (empty && !part.final && (!worst || part.excess > worst->excess)) worst = &part;
        }
        if (!worst) break;
        if (worst->mesh.positions.empty())
            worst->mesh = {{positions.begin(), positions.end()}, {triangles.begin(), triangles.end()}};
        std::vector<Part> halves = cut(worst->mesh, workspace, scratch);
        if (halves.empty() || parts.size() - 1 + halves.size() > settings.max_parts) {
            worst->final = true;
            continue;
        }
        *worst = std::move(halves[0]);
        for (size_t k = 1; k < halves.size(); ++k) parts.push_back(std::move(halves[k]));
    }
    std::vector<BodyPart> result;
    for (const Part& part : parts) {
        const glm::dvec3 centre = middle_of(part.points);
        result.push_back({std::make_shared<const CollisionHull>(collision_hull(part.points, centre, settings.hull)),
                          glm::vec3(centre - origin)});
    }
    return result;
}

} // namespace brittle::physics
