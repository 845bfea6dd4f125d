#include "fracture/shapes/shapes.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <numeric>
#include <unordered_map>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "fracture/base/rounded_math.h"
#include "fracture/triangulation/triangulate.h"

namespace brittle::fracture {
namespace {

constexpr uint32_t max_subdivisions = 10; // 21 million triangles
constexpr uint32_t max_segments = 4096;
constexpr uint32_t max_sponge_level = 4; // 6 million triangles

uint64_t pair_key(uint32_t a, uint32_t b) {
    return static_cast<uint64_t>(std::min(a, b)) << 32 | std::max(a, b);
}

void append(TriangleMesh& mesh, const TriangleMesh& other) {
    const auto offset = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
    for (const Triangle& t : other.triangles) mesh.triangles.push_back(t + Triangle(offset));
}

// The vertices of a mesh on a cube's lattice of n steps, created on first use.
class LatticeVertices {
  public:
    LatticeVertices(TriangleMesh& mesh, uint32_t n, double edge) : mesh_(mesh), n_(n), edge_(edge) {}

    uint32_t operator()(const glm::uvec3& p) {
        const uint64_t key = (static_cast<uint64_t>(p.x) * (n_ + 1) + p.y) * (n_ + 1) + p.z;
        const auto [at, is_new] = index_of_.try_emplace(key, static_cast<uint32_t>(mesh_.positions.size()));
        if (is_new) mesh_.positions.push_back((glm::dvec3(p) / static_cast<double>(n_) - 0.5) * edge_);
        return at->second;
    }

  private:
    TriangleMesh& mesh_;
    uint32_t n_;
    double edge_;
    std::unordered_map<uint64_t, uint32_t> index_of_;
};

// Returns the triangles of a grid of n x m points that wraps around in both directions; point (i, j) has index i * m +
// j. They face the side from which a step in i followed by a step in j turns counter-clockwise.
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

// Divides each triangle into four at the midpoints of its edges.
void subdivide(TriangleMesh& mesh) {
    std::unordered_map<uint64_t, uint32_t> midpoints;
    midpoints.reserve(mesh.triangles.size() * 3 / 2);
    const auto midpoint = [&](uint32_t a, uint32_t b) {
        const auto [at, is_new] = midpoints.try_emplace(pair_key(a, b), static_cast<uint32_t>(mesh.positions.size()));
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
    LatticeVertices vertex(mesh, n, edge);
    for (int axis = 0; axis < 3; ++axis) {
        for (const uint32_t side : {0u, n}) {
            // u, v and the outward axis form a right-handed frame on the far side, a left-handed one on the near side.
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

TriangleMesh torus(uint32_t major_segments, uint32_t minor_segments, double major_radius, double minor_radius) {
    const uint32_t n = std::clamp(major_segments, 3u, max_segments);
    const uint32_t m = std::clamp(minor_segments, 3u, max_segments);
    TriangleMesh mesh;
    mesh.triangles = wrapped_grid(n, m);
    for (uint32_t i = 0; i < n; ++i) {
        const double u = 2.0 * std::numbers::pi * i / n;
        for (uint32_t j = 0; j < m; ++j) {
            const double v = 2.0 * std::numbers::pi * j / m;
            const double from_axis = major_radius + minor_radius * rounded::cos(v);
            mesh.positions.emplace_back(from_axis * rounded::sin(u), minor_radius * rounded::sin(v),
                                        from_axis * rounded::cos(u));
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
        const double from_axis = major_radius + minor_radius * rounded::cos(v);
        const glm::dvec3 outward(rounded::sin(u), 0, rounded::cos(u));
        const glm::dvec3 along(rounded::cos(u), 0, -rounded::sin(u));
        const glm::dvec3 centre = outward * from_axis + glm::dvec3(0, minor_radius * rounded::sin(v), 0);
        // The curve lies on a torus, whose normal is perpendicular to it. This frame closes without a twist correction.
        const glm::dvec3 normal = outward * rounded::cos(v) + glm::dvec3(0, rounded::sin(v), 0);
        const glm::dvec3 up = -outward * rounded::sin(v) + glm::dvec3(0, rounded::cos(v), 0);
        const glm::dvec3 tangent = normalize(along * (turns_major * from_axis) + up * (turns_minor * minor_radius));
        const glm::dvec3 binormal = cross(tangent, normal);
        for (uint32_t j = 0; j < m; ++j) {
            const double w = 2.0 * std::numbers::pi * j / m;
            mesh.positions.push_back(centre + (normal * rounded::cos(w) - binormal * rounded::sin(w)) * tube_radius);
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

TriangleMesh menger_sponge(uint32_t level, double edge) {
    uint32_t n = 1;
    for (uint32_t k = 0; k < std::min(level, max_sponge_level); ++k) n *= 3;
    const auto solid = [n](glm::uvec3 p) { // coordinates below 0 wrap around
        if (p.x >= n || p.y >= n || p.z >= n) return false;
        for (; p != glm::uvec3(0); p /= 3u) {
            const uint32_t middle = (p.x % 3 == 1) + (p.y % 3 == 1) + (p.z % 3 == 1);
            if (middle >= 2) return false;
        }
        return true;
    };
    TriangleMesh mesh;
    LatticeVertices vertex(mesh, n, edge);
    for (uint32_t x = 0; x < n; ++x)
        for (uint32_t y = 0; y < n; ++y)
            for (uint32_t z = 0; z < n; ++z)
                for (int side = 0; side < 6 && solid({x, y, z}); ++side) {
                    const int axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
                    glm::uvec3 beyond(x, y, z), a(x, y, z), b, c, d;
                    beyond[axis] += side % 2 == 1 ? 1u : ~0u;
                    if (solid(beyond)) continue;
                    a[axis] += side % 2;
                    b = c = d = a;
                    ++b[u], ++c[u], ++c[v], ++d[v];
                    if (side % 2 == 0) std::swap(b, d);
                    mesh.triangles.push_back({vertex(a), vertex(b), vertex(c)});
                    mesh.triangles.push_back({vertex(a), vertex(c), vertex(d)});
                }
    return mesh;
}

TriangleMesh cuboid(const glm::dvec3& size) {
    TriangleMesh mesh = cube(1.0);
    for (glm::dvec3& p : mesh.positions) p *= size;
    return mesh;
}

TriangleMesh arch(uint32_t segments) {
    segments = std::clamp(segments, 2u, 4096u);
    // The outline, counter-clockwise seen from +Z: around the outside, then back along the opening.
    constexpr double width = 1.0, inner = 0.6, spring = 0.7, height = 1.5, depth = 0.15;
    std::vector<glm::dvec2> outline = {{inner, 0.0},     {width, 0.0},  {width, height},
                                       {-width, height}, {-width, 0.0}, {-inner, 0.0}};
    for (uint32_t k = 0; k <= segments; ++k) {
        const double angle = std::numbers::pi * (1.0 - static_cast<double>(k) / segments);
        outline.emplace_back(inner * rounded::cos(angle), spring + inner * rounded::sin(angle));
    }
    const auto n = static_cast<uint32_t>(outline.size());
    TriangleMesh mesh;
    for (const double z : {-depth, depth})
        for (const glm::dvec2& p : outline) mesh.positions.emplace_back(p.x, p.y, z);
    Loop loop(n);
    for (uint32_t k = 0; k < n; ++k) {
        loop[k] = k;
        const uint32_t next = (k + 1) % n;
        mesh.triangles.emplace_back(k, next, n + next);
        mesh.triangles.emplace_back(k, n + next, n + k);
    }
    for (const Triangle& t : triangulate(outline, {&loop, 1}).triangles) {
        mesh.triangles.push_back(t + n);
        mesh.triangles.emplace_back(t.x, t.z, t.y);
    }
    return mesh;
}

// A wall of 48 x 8 cells around the axis, one cell thick. Every cell outside the openings is filled and has a quad
// towards each empty neighbour. Cell coordinates are (around from +Z towards +X, up, outwards), which is right-handed.
TriangleMesh tower() {
    struct Level {
        double height, radius;
    };
    constexpr uint32_t around = 48;
    constexpr double inner = 0.27;
    constexpr std::array<Level, 9> levels = {{{0.0, 0.46},
                                              {0.12, 0.42},
                                              {0.5, 0.4},
                                              {0.8, 0.385},
                                              {1.05, 0.375},
                                              {1.4, 0.36},
                                              {1.52, 0.43},
                                              {1.72, 0.43},
                                              {2.0, 0.43}}};
    const auto filled = [](const glm::ivec3& cell) {
        if (cell.y < 0 || cell.y >= 8 || cell.z != 0) return false;
        const int i = (cell.x + static_cast<int>(around)) % static_cast<int>(around);
        if (cell.y < 2 && (i < 3 || i >= 45)) return false;                   // the door
        if (cell.y == 3 && i > 6 && i < 42 && (i + 1) % 12 < 2) return false; // windows on the other three sides
        return cell.y != 7 || (i + 2) % 6 < 4;                                // merlons
    };
    TriangleMesh mesh;
    std::array<uint32_t, around * levels.size() * 2> index_of;
    index_of.fill(UINT32_MAX);
    const auto vertex = [&](const glm::ivec3& at) {
        const auto i = static_cast<uint32_t>(at.x) % around;
        const auto y = static_cast<size_t>(at.y);
        uint32_t& index = index_of[(i * levels.size() + y) * 2 + static_cast<size_t>(at.z)];
        if (index != UINT32_MAX) return index;
        const double angle = 2.0 * std::numbers::pi * i / around;
        const double radius = at.z == 0 ? inner : levels[y].radius;
        mesh.positions.emplace_back(radius * rounded::sin(angle), levels[y].height, radius * rounded::cos(angle));
        return index = static_cast<uint32_t>(mesh.positions.size() - 1);
    };
    for (glm::ivec3 cell(0); cell.x < static_cast<int>(around); ++cell.x)
        for (cell.y = 0; cell.y < 8; ++cell.y) {
            if (!filled(cell)) continue;
            for (int axis = 0; axis < 3; ++axis)
                for (const int side : {0, 1}) {
                    glm::ivec3 out(0), u(0), v(0);
                    out[axis] = u[(axis + 1) % 3] = v[(axis + 2) % 3] = 1;
                    if (filled(cell + (side == 1 ? out : -out))) continue;
                    if (side == 0) std::swap(u, v);
                    const glm::ivec3 corner = cell + side * out;
                    const uint32_t a = vertex(corner), b = vertex(corner + u), c = vertex(corner + u + v),
                                   d = vertex(corner + v);
                    mesh.triangles.emplace_back(a, b, c);
                    mesh.triangles.emplace_back(a, c, d);
                }
        }
    return mesh;
}

std::span<const std::string_view> shape_names() {
    static constexpr std::array<std::string_view, 23> names = {
        "cube",  "lattice_cube", "icosphere",  "torus",      "torus_knot",    "hollow_sphere", "menger_sponge", "pane",
        "wall",  "arch",         "tower",      "animal",     "statue",        "vase",          "plate",         "table",
        "basin", "stairs",       "stone_arch", "card_house", "domino_spiral", "pyramid",       "stack"};
    return names;
}

namespace {

// Returns nothing if the name is unknown or has no size parameter, or if the size is not a number.
std::optional<TriangleMesh> shape_of_size(std::string_view name, std::string_view size) {
    uint32_t n = 0;
    const auto [end, status] = std::from_chars(size.data(), size.data() + size.size(), n);
    if (status != std::errc() || end != size.data() + size.size()) return std::nullopt;
    if (name == "lattice_cube") return lattice_cube(n);
    if (name == "icosphere") return icosphere(n);
    if (name == "torus") return torus(n, n / 2);
    if (name == "torus_knot") return torus_knot(2, 3, n, n / 16);
    if (name == "menger_sponge") return menger_sponge(n);
    if (name == "animal") return four_legged_animal(n);
    if (name == "statue") return statue(n);
    if (name == "vase") return vase(n);
    if (name == "plate") return plate(n);
    if (name == "table") return round_table(n);
    if (name == "basin") return basin(n);
    if (name == "stairs") return stairs(n);
    if (name == "stone_arch") return stone_arch(0.01 * std::clamp(n, 1u, 100u));
    if (name == "card_house") return card_house(n);
    if (name == "domino_spiral") return domino_spiral(n);
    if (name == "pyramid") return pyramid(n);
    if (name == "stack") return stack(n);
    return std::nullopt;
}

} // namespace

std::optional<TriangleMesh> shape(std::string_view name) {
    if (const size_t colon = name.find(':'); colon != std::string_view::npos)
        return shape_of_size(name.substr(0, colon), name.substr(colon + 1));
    if (name == "cube") return cube();
    if (name == "lattice_cube") return lattice_cube(16);
    if (name == "icosphere") return icosphere();
    if (name == "torus") return torus();
    if (name == "torus_knot") return torus_knot();
    if (name == "hollow_sphere") return hollow_sphere();
    if (name == "menger_sponge") return menger_sponge();
    if (name == "pane") return cuboid({2.0, 1.4, 0.03});
    if (name == "wall") return cuboid({2.0, 1.2, 0.2});
    if (name == "arch") return arch();
    if (name == "tower") return tower();
    if (name == "animal") return four_legged_animal();
    if (name == "statue") return statue();
    if (name == "vase") return vase();
    if (name == "plate") return plate();
    if (name == "table") return round_table();
    if (name == "basin") return basin();
    if (name == "stairs") return stairs();
    if (name == "stone_arch") return stone_arch();
    if (name == "card_house") return card_house();
    if (name == "domino_spiral") return domino_spiral();
    if (name == "pyramid") return pyramid();
    if (name == "stack") return stack();
    return std::nullopt;
}

} // namespace brittle::fracture
