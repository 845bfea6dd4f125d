#include "fracture/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <unordered_map>

#include <glm/geometric.hpp>

namespace brittle::fracture {
namespace {

constexpr uint32_t max_subdivisions = 10; // 21 million triangles
constexpr uint32_t max_segments = 4096;

uint64_t pair_key(uint32_t a, uint32_t b) {
    return static_cast<uint64_t>(std::min(a, b)) << 32 | std::max(a, b);
}

void append(TriangleMesh& mesh, const TriangleMesh& other) {
    const auto offset = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
    for (const Triangle& t : other.triangles) mesh.triangles.push_back(t + Triangle(offset));
}

// Triangles of a grid of n x m points that wraps around both ways; point (i, j) has index i * m + j. Facing
// the side from which a step in i followed by a step in j turns counter-clockwise.
std::vector<Triangle> wrapped_grid(uint32_t n, uint32_t m) {
    std::vector<Triangle> triangles;
    triangles.reserve(size_t{2} * n * m);
    for (uint32_t i = 0; i < n; ++i) {
        for (uint32_t j = 0; j < m; ++j) {
            const uint32_t i1 = (i + 1) % n;
            const uint32_t j1 = (j + 1) % m;
            triangles.push_back({i * m + j, i1 * m + j, i1 * m + j1});
            triangles.push_back({i * m + j, i1 * m + j1, i * m + j1});
        }
    }
    return triangles;
}

TriangleMesh icosahedron() {
    constexpr double t = std::numbers::phi;
    return {{{-1, t, 0},
             {1, t, 0},
             {-1, -t, 0},
             {1, -t, 0},
             {0, -1, t},
             {0, 1, t},
             {0, -1, -t},
             {0, 1, -t},
             {t, 0, -1},
             {t, 0, 1},
             {-t, 0, -1},
             {-t, 0, 1}},
            {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
             {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
             {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
}

// Each triangle into four at the midpoints of its edges.
void subdivide(TriangleMesh& mesh) {
    std::unordered_map<uint64_t, uint32_t> midpoints;
    midpoints.reserve(mesh.triangles.size() * 3 / 2);
    const auto midpoint = [&](uint32_t a, uint32_t b) {
        const auto [at, is_new] =
            midpoints.try_emplace(pair_key(a, b), static_cast<uint32_t>(mesh.positions.size()));
        if (is_new) mesh.positions.push_back((mesh.positions[a] + mesh.positions[b]) * 0.5);
        return at->second;
    };
    std::vector<Triangle> triangles;
    triangles.reserve(mesh.triangles.size() * 4);
    for (const Triangle& t : mesh.triangles) {
        const uint32_t a = midpoint(t.x, t.y);
        const uint32_t b = midpoint(t.y, t.z);
        const uint32_t c = midpoint(t.z, t.x);
        triangles.insert(triangles.end(), {{t.x, a, c}, {t.y, b, a}, {t.z, c, b}, {a, b, c}});
    }
    mesh.triangles = std::move(triangles);
}

} // namespace

TriangleMesh cube(double edge) {
    return lattice_cube(1, edge);
}

TriangleMesh lattice_cube(uint32_t n, double edge) {
    n = std::clamp(n, 1u, max_segments);
    TriangleMesh mesh;
    std::unordered_map<uint64_t, uint32_t> index_of;
    const auto vertex = [&](const glm::uvec3& p) {
        const uint64_t key = (static_cast<uint64_t>(p.x) * (n + 1) + p.y) * (n + 1) + p.z;
        const auto [at, is_new] = index_of.try_emplace(key, static_cast<uint32_t>(mesh.positions.size()));
        if (is_new) mesh.positions.push_back((glm::dvec3(p) / static_cast<double>(n) - 0.5) * edge);
        return at->second;
    };
    for (int axis = 0; axis < 3; ++axis) {
        for (const uint32_t side : {0u, n}) {
            // u, v and the outward axis are right-handed on the far side, left-handed on the near one.
            const int u = (axis + (side == n ? 1 : 2)) % 3;
            const int v = (axis + (side == n ? 2 : 1)) % 3;
            const auto corner = [&](uint32_t i, uint32_t j) {
                glm::uvec3 p;
                p[axis] = side;
                p[u] = i;
                p[v] = j;
                return vertex(p);
            };
            for (uint32_t i = 0; i < n; ++i) {
                for (uint32_t j = 0; j < n; ++j) {
                    const uint32_t a = corner(i, j), b = corner(i + 1, j);
                    const uint32_t c = corner(i + 1, j + 1), d = corner(i, j + 1);
                    mesh.triangles.push_back({a, b, c});
                    mesh.triangles.push_back({a, c, d});
                }
            }
        }
    }
    return mesh;
}

TriangleMesh icosphere(uint32_t subdivisions, double radius) {
    TriangleMesh mesh = icosahedron();
    for (uint32_t k = 0; k < std::min(subdivisions, max_subdivisions); ++k) {
        for (glm::dvec3& p : mesh.positions) p = normalize(p);
        subdivide(mesh);
    }
    for (glm::dvec3& p : mesh.positions) p = normalize(p) * radius;
    return mesh;
}

TriangleMesh torus(uint32_t major_segments, uint32_t minor_segments, double major_radius,
                   double minor_radius) {
    const uint32_t n = std::clamp(major_segments, 3u, max_segments);
    const uint32_t m = std::clamp(minor_segments, 3u, max_segments);
    TriangleMesh mesh;
    mesh.triangles = wrapped_grid(n, m);
    for (uint32_t i = 0; i < n; ++i) {
        const double u = 2.0 * std::numbers::pi * i / n;
        for (uint32_t j = 0; j < m; ++j) {
            const double v = 2.0 * std::numbers::pi * j / m;
            const double from_axis = major_radius + minor_radius * std::cos(v);
            mesh.positions.emplace_back(from_axis * std::sin(u), minor_radius * std::sin(v),
                                        from_axis * std::cos(u));
        }
    }
    return mesh;
}

TriangleMesh torus_knot(uint32_t p, uint32_t q, uint32_t segments, uint32_t ring, double tube_radius) {
    p = std::clamp(p, 1u, max_segments);
    q = std::clamp(q, 1u, max_segments);
    const uint32_t divisor = std::gcd(p, q);
    const double turns_major = p / divisor;
    const double turns_minor = q / divisor;
    const uint32_t n = std::clamp(segments, 3u, 16 * max_segments);
    const uint32_t m = std::clamp(ring, 3u, max_segments);
    constexpr double major_radius = 1.0;
    constexpr double minor_radius = 0.5;
    TriangleMesh mesh;
    mesh.triangles = wrapped_grid(n, m);
    for (uint32_t i = 0; i < n; ++i) {
        const double t = 2.0 * std::numbers::pi * i / n;
        const double u = turns_major * t;
        const double v = turns_minor * t;
        const double from_axis = major_radius + minor_radius * std::cos(v);
        const glm::dvec3 outward(std::sin(u), 0, std::cos(u));
        const glm::dvec3 along(std::cos(u), 0, -std::sin(u));
        const glm::dvec3 centre = outward * from_axis + glm::dvec3(0, minor_radius * std::sin(v), 0);
        // The curve lies on a torus, whose normal is perpendicular to it: a frame that closes without twist
        // correction.
        const glm::dvec3 normal = outward * std::cos(v) + glm::dvec3(0, std::sin(v), 0);
        const glm::dvec3 up = -outward * std::sin(v) + glm::dvec3(0, std::cos(v), 0);
        const glm::dvec3 tangent =
            normalize(along * (turns_major * from_axis) + up * (turns_minor * minor_radius));
        const glm::dvec3 binormal = cross(tangent, normal);
        for (uint32_t j = 0; j < m; ++j) {
            const double w = 2.0 * std::numbers::pi * j / m;
            mesh.positions.push_back(centre + (normal * std::cos(w) - binormal * std::sin(w)) * tube_radius);
        }
    }
    return mesh;
}

TriangleMesh hollow_sphere(uint32_t subdivisions, double radius, double cavity) {
    TriangleMesh mesh = icosphere(subdivisions, radius);
    TriangleMesh inner = icosphere(subdivisions, cavity);
    for (Triangle& t : inner.triangles) std::swap(t.y, t.z);
    append(mesh, inner);
    return mesh;
}

} // namespace brittle::fracture
