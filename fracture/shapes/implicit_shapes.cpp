// The implicit surfaces of shapes.h, polygonised by marching tetrahedra.
#include "fracture/shapes/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace brittle::fracture {
namespace {

// A segment with a radius at each end (a tapered capsule).
struct Bone {
    glm::dvec3 a, b;
    double radius_a, radius_b;
    double blend;          // m, the extent of the smooth blend with the preceding primitives
    bool mirrored = false; // whether it has a mirror image at -x
};

// The animal, in metres: feet near y = 0, looking along +Z. Mirrored bones describe its half at x > 0.
constexpr std::array<Bone, 14> calf = {{
    {{0, 0.98, -0.52}, {0, 0.96, 0.45}, 0.33, 0.35, 0.0},                // trunk
    {{0, 0.86, -0.10}, {0, 0.85, 0.20}, 0.29, 0.29, 0.15},               // belly
    {{0, 1.05, 0.55}, {0, 1.34, 0.88}, 0.25, 0.16, 0.18},                // neck
    {{0, 1.41, 0.93}, {0, 1.27, 1.24}, 0.17, 0.12, 0.08},                // head
    {{0, 1.24, 1.28}, {0, 1.23, 1.32}, 0.125, 0.115, 0.05},              // muzzle
    {{0.18, 0.85, 0.47}, {0.20, 0.50, 0.48}, 0.17, 0.09, 0.12, true},    // upper foreleg
    {{0.20, 0.50, 0.48}, {0.20, 0.10, 0.50}, 0.085, 0.085, 0.03, true},  // foreleg
    {{0.18, 0.88, -0.55}, {0.21, 0.50, -0.66}, 0.22, 0.095, 0.12, true}, // thigh
    {{0.21, 0.50, -0.66}, {0.21, 0.10, -0.60}, 0.09, 0.085, 0.03, true}, // hind leg
    {{0.13, 1.46, 0.87}, {0.31, 1.41, 0.82}, 0.05, 0.07, 0.04, true},    // ear
    {{0.08, 1.53, 0.91}, {0.17, 1.66, 0.93}, 0.055, 0.045, 0.03, true},  // horn
    {{0, 1.20, -0.80}, {0, 1.05, -0.99}, 0.055, 0.05, 0.06},             // tail
    {{0, 1.05, -0.99}, {0, 0.62, -1.06}, 0.05, 0.05, 0.02},              // tail, hanging
    {{0, 0.62, -1.06}, {0, 0.52, -1.06}, 0.075, 0.06, 0.04},             // tuft
}};

// Returns a smooth minimum (Quilez), equal to the minimum if the arguments differ by more than k.
double smooth_min(double a, double b, double k) {
    if (k <= 0.0) return std::min(a, b);
    const double h = std::max(k - std::abs(a - b), 0.0) / k;
    return std::min(a, b) - h * h * k * 0.25;
}

double distance_to(const Bone& bone, const glm::dvec3& p) {
    const glm::dvec3 along = bone.b - bone.a;
    const double t = std::clamp(dot(p - bone.a, along) / dot(along, along), 0.0, 1.0);
    return length(p - bone.a - along * t) - (bone.radius_a + (bone.radius_b - bone.radius_a) * t);
}

// A box with rounded edges.
struct Slab {
    glm::dvec3 centre, half;
    double radius; // of the edges
    double blend;  // as in Bone
};

// A man in a long robe on a plinth, one arm raised: y from 0 to 2 m, looking along +Z.
constexpr std::array<Bone, 15> robed_man = {{
    {{0, 0.40, 0.00}, {0, 0.98, 0.0}, 0.215, 0.125, 0.0},        // robe
    {{0.09, 0.40, 0.10}, {0.06, 0.90, 0.05}, 0.085, 0.06, 0.05}, // folds of the robe
    {{-0.10, 0.40, 0.09}, {-0.07, 0.90, 0.04}, 0.08, 0.06, 0.05},
    {{0.0, 0.40, 0.16}, {0.0, 0.85, 0.08}, 0.06, 0.05, 0.04},
    {{0, 1.00, 0.0}, {0, 1.28, 0.01}, 0.125, 0.13, 0.10},        // chest
    {{-0.15, 1.36, 0.0}, {0.15, 1.36, 0.0}, 0.075, 0.075, 0.12}, // shoulders
    {{0, 1.38, 0.0}, {0, 1.50, 0.02}, 0.06, 0.055, 0.06},        // neck
    {{0, 1.60, 0.03}, {0, 1.65, 0.02}, 0.085, 0.095, 0.04},      // head
    {{0, 1.52, 0.07}, {0, 1.55, 0.07}, 0.045, 0.05, 0.06},       // beard
    {{0.20, 1.36, 0.0}, {0.34, 1.56, 0.06}, 0.065, 0.055, 0.06}, // the raised arm
    {{0.34, 1.56, 0.06}, {0.36, 1.84, 0.14}, 0.052, 0.042, 0.03},
    {{0.36, 1.88, 0.15}, {0.36, 1.95, 0.17}, 0.05, 0.035, 0.03},   // hand of the raised arm
    {{-0.21, 1.34, 0.0}, {-0.27, 1.08, 0.04}, 0.065, 0.055, 0.06}, // lowered arm
    {{-0.27, 1.08, 0.04}, {-0.08, 1.00, 0.17}, 0.052, 0.045, 0.03},
    {{-0.08, 1.02, 0.10}, {-0.05, 0.55, 0.17}, 0.05, 0.07, 0.05}, // end of the robe over the lowered arm
}};
constexpr std::array<Slab, 3> plinth = {{
    {{0, 0.05, 0}, {0.38, 0.06, 0.38}, 0.015, 0.0},
    {{0, 0.20, 0}, {0.30, 0.14, 0.30}, 0.015, 0.0},
    {{0, 0.36, 0}, {0.34, 0.035, 0.34}, 0.015, 0.0},
}};

double distance_to(const Slab& slab, const glm::dvec3& p) {
    const glm::dvec3 out = abs(p - slab.centre) - (slab.half - slab.radius);
    return length(max(out, 0.0)) + std::min(std::max({out.x, out.y, out.z}), 0.0) - slab.radius;
}

// The union of primitives whose surface is polygonised.
struct Body {
    std::span<const Bone> bones;
    std::span<const Slab> slabs{};

    // Returns a signed field: negative inside, approximately the distance near the surface.
    [[nodiscard]] double field(const glm::dvec3& p) const {
        const glm::dvec3 mirrored(std::abs(p.x), p.y, p.z);
        double field = std::numeric_limits<double>::max();
        for (const Bone& bone : bones)
            field = smooth_min(field, distance_to(bone, bone.mirrored ? mirrored : p), bone.blend);
        for (const Slab& slab : slabs) field = smooth_min(field, distance_to(slab, p), slab.blend);
        return field;
    }

    [[nodiscard]] glm::dvec3 gradient(const glm::dvec3& p) const {
        constexpr double h = 1e-5;
        glm::dvec3 gradient;
        for (int k = 0; k < 3; ++k) {
            glm::dvec3 step(0.0);
            step[k] = h;
            gradient[k] = (field(p + step) - field(p - step)) / (2.0 * h);
        }
        return gradient;
    }

    // Moves p onto the surface by Newton's method, with a bound on the length of a step.
    [[nodiscard]] glm::dvec3 onto(glm::dvec3 p, double longest_step) const {
        constexpr double near_enough = 1e-4; // m
        for (int k = 0; k < 4; ++k) {
            const double value = field(p);
            if (std::abs(value) < near_enough) break;
            const glm::dvec3 slope = gradient(p);
            glm::dvec3 step = slope * (-value / std::max(dot(slope, slope), 1e-6));
            const double size = length(step);
            if (size > longest_step) step *= longest_step / size;
            p += step;
        }
        return p;
    }
};

// Marching tetrahedra over Kuhn's six tetrahedra of each lattice cube. There are no ambiguous cases, so the surface is
// closed and manifold for any field that is positive on the rim of the lattice.
class TetrahedraMarcher {
  public:
    TetrahedraMarcher(const Body& body, const glm::dvec3& origin, const glm::uvec3& cells, double spacing)
        : origin_(origin), points_(cells + glm::uvec3(1)), spacing_(spacing),
          values_(size_t{points_.x} * points_.y * points_.z) {
        for (size_t i = 0; i < values_.size(); ++i) values_[i] = body.field(position(i));
    }

    TriangleMesh run() {
        glm::uvec3 at;
        for (at.z = 0; at.z + 1 < points_.z; ++at.z) {
            for (at.y = 0; at.y + 1 < points_.y; ++at.y) {
                for (at.x = 0; at.x + 1 < points_.x; ++at.x) march_cube(at);
            }
        }
        return std::move(mesh_);
    }

  private:
    size_t index(const glm::uvec3& at) const { return (size_t{at.z} * points_.y + at.y) * points_.x + at.x; }
    glm::dvec3 position(size_t i) const {
        const glm::dvec3 at(static_cast<double>(i % points_.x), static_cast<double>(i / points_.x % points_.y),
                            static_cast<double>(i / points_.x / points_.y));
        return origin_ + at * spacing_;
    }

    void march_cube(const glm::uvec3& at) {
        constexpr std::array<std::array<int, 3>, 6> paths = {
            // Permutations of the axes; the last three are odd.
            {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
        for (size_t k = 0; k < paths.size(); ++k) {
            std::array<size_t, 4> tetrahedron{};
            glm::uvec3 corner = at;
            tetrahedron[0] = index(corner);
            for (size_t step = 0; step < 3; ++step) {
                ++corner[paths[k][step]];
                tetrahedron[step + 1] = index(corner);
            }
            if (k >= 3) std::swap(tetrahedron[1], tetrahedron[2]); // makes odd ones right-handed
            march_tetrahedron(tetrahedron);
        }
    }

    void march_tetrahedron(const std::array<size_t, 4>& v) {
        const auto inside = [&](size_t k) { return values_[v[k]] < 0.0; };
        size_t count = 0;
        for (size_t k = 0; k < 4; ++k) count += inside(k);
        if (count == 0 || count == 4) return;
        // Even permutations. One of them brings the inside vertices to the front, or the single outside one.
        constexpr std::array<std::array<size_t, 4>, 12> even = {{{0, 1, 2, 3},
                                                                 {0, 2, 3, 1},
                                                                 {0, 3, 1, 2},
                                                                 {1, 0, 3, 2},
                                                                 {1, 2, 0, 3},
                                                                 {1, 3, 2, 0},
                                                                 {2, 0, 1, 3},
                                                                 {2, 1, 3, 0},
                                                                 {2, 3, 0, 1},
                                                                 {3, 0, 2, 1},
                                                                 {3, 1, 0, 2},
                                                                 {3, 2, 1, 0}}};
        for (const auto& [i, j, k, l] : even) {
            if (count == 2 ? !(inside(i) && inside(j)) : inside(i) != (count == 1)) continue;
            // Braced lists fix the order of evaluation, and with it the numbering of the vertices.
            const auto cut = [&](size_t a, size_t b) { return vertex_between(v[a], v[b]); };
            if (count == 1) mesh_.triangles.push_back({cut(i, j), cut(i, k), cut(i, l)});
            if (count == 3) mesh_.triangles.push_back({cut(i, j), cut(i, l), cut(i, k)});
            if (count == 2) {
                mesh_.triangles.push_back({cut(i, k), cut(i, l), cut(j, l)});
                mesh_.triangles.push_back({cut(i, k), cut(j, l), cut(j, k)});
            }
            return;
        }
    }

    uint32_t vertex_between(size_t a, size_t b) {
        if (a > b) std::swap(a, b);
        const uint64_t key = static_cast<uint64_t>(a) << 32 | b;
        const auto [at, is_new] = vertices_.try_emplace(key, static_cast<uint32_t>(mesh_.positions.size()));
        if (is_new) {
            // Kept away from lattice points: vertices that crowd around one form slivers.
            const double t = std::clamp(values_[a] / (values_[a] - values_[b]), 0.15, 0.85);
            mesh_.positions.push_back(position(a) + (position(b) - position(a)) * t);
        }
        return at->second;
    }

    glm::dvec3 origin_;
    glm::uvec3 points_;
    double spacing_;
    std::vector<double> values_;
    std::unordered_map<uint64_t, uint32_t> vertices_;
    TriangleMesh mesh_;
};

// Moves each vertex towards the mean of its neighbours, within the tangent plane of the surface.
void relax(const Body& body, TriangleMesh& mesh, double spacing, int rounds) {
    std::vector<glm::dvec3> sum(mesh.positions.size());
    std::vector<double> weight(mesh.positions.size());
    for (int round = 0; round < rounds; ++round) {
        std::fill(sum.begin(), sum.end(), glm::dvec3(0.0));
        std::fill(weight.begin(), weight.end(), 0.0);
        for (const Triangle& t : mesh.triangles) {
            for (int k = 0; k < 3; ++k) {
                sum[t[k]] += mesh.positions[t[(k + 1) % 3]];
                weight[t[k]] += 1.0;
            }
        }
        for (size_t i = 0; i < mesh.positions.size(); ++i) {
            glm::dvec3& p = mesh.positions[i];
            const glm::dvec3 gradient = body.gradient(p);
            glm::dvec3 step = (sum[i] / weight[i] - p) * 0.5;
            step -= gradient * (dot(step, gradient) / std::max(dot(gradient, gradient), 1e-6));
            p = body.onto(p + step, 0.25 * spacing);
        }
    }
}

} // namespace

TriangleMesh four_legged_animal(uint32_t resolution) {
    const Body body{calf};
    // Below 56 cells along the length, the tips of the horns fall between lattice points.
    const double spacing = 2.7 / std::clamp(resolution, 56u, 160u);
    const glm::dvec3 low(-0.5, -0.1, -1.22), high(0.5, 1.9, 1.54);
    // The lattice is half a cell off the plane of symmetry, so that no lattice point lies on that plane.
    const auto half_width = static_cast<uint32_t>(std::ceil(high.x / spacing)) + 1;
    const glm::dvec3 size = high - low;
    const glm::uvec3 cells(2 * half_width - 1, static_cast<uint32_t>(size.y / spacing) + 2,
                           static_cast<uint32_t>(size.z / spacing) + 2);
    const glm::dvec3 origin(-(half_width - 0.5) * spacing, low.y, low.z);
    TriangleMesh mesh = TetrahedraMarcher(body, origin, cells, spacing).run();
    relax(body, mesh, spacing, 8);
    const double ground = bounds(mesh).min.y;
    for (glm::dvec3& p : mesh.positions) p.y -= ground;
    return mesh;
}

TriangleMesh statue(uint32_t resolution) {
    const Body body{robed_man, plinth};
    // Below 40 cells along the height, the raised arm breaks into separate beads.
    const double spacing = 2.0 / std::clamp(resolution, 40u, 160u);
    const glm::dvec3 low(-0.5, -0.1, -0.5);
    const auto half_width = static_cast<uint32_t>(std::ceil(0.5 / spacing)) + 1;
    const glm::uvec3 cells(2 * half_width - 1, static_cast<uint32_t>(2.2 / spacing) + 2,
                           static_cast<uint32_t>(1.0 / spacing) + 2);
    TriangleMesh mesh = TetrahedraMarcher(body, {-(half_width - 0.5) * spacing, low.y, low.z}, cells, spacing).run();
    relax(body, mesh, spacing, 8);
    const double ground = bounds(mesh).min.y;
    for (glm::dvec3& p : mesh.positions) p.y -= ground;
    return mesh;
}

} // namespace brittle::fracture
