#include "fracture/local/lids.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/mesh/half_edge.h"

namespace brittle::fracture {

namespace {

// Length of a strip by the distance of its border from the middle of the region, and distance of the apexes by the size
// of all strips.
constexpr double strip_length = 16.0, apex_distance = 8.0;
// The region grows by this share of its size before the lids are tested against it.
constexpr double margin = 1e-3;

uint64_t key(uint32_t from, uint32_t to) {
    return uint64_t{from} << 32 | to;
}

// Half-edges of a patch, each with the triangle it belongs to.
class HalfEdges {
  public:
    explicit HalfEdges(std::span<const Triangle> triangles) : triangles_(triangles) {
        triangle_.reserve(triangles.size() * 3);
        for (uint32_t t = 0; t < triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) triangle_.emplace(key(triangles[t][k], triangles[t][(k + 1) % 3]), t);
    }

    [[nodiscard]] bool contains(uint32_t from, uint32_t to) const { return triangle_.contains(key(from, to)); }

    // The border edge that follows a border edge: the next one around its end.
    [[nodiscard]] uint32_t end_of_next(uint32_t from, uint32_t at) const {
        for (;;) {
            const Triangle& t = triangles_[triangle_.at(key(from, at))];
            const int k = t.x == at ? 0 : t.y == at ? 1 : 2;
            const uint32_t to = t[(k + 1) % 3];
            if (!contains(to, at)) return to;
            from = to;
        }
    }

  private:
    std::span<const Triangle> triangles_;
    std::unordered_map<uint64_t, uint32_t> triangle_;
};

// Separating axes of a triangle and a box centred at the origin (Akenine-Moeller 2001). False only where they are
// certainly apart.
bool may_meet(std::array<glm::dvec3, 3> corners, const glm::dvec3& half) {
    const std::array<glm::dvec3, 3> sides{corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]};
    const auto apart = [&](const glm::dvec3& axis) {
        const double a = glm::dot(axis, corners[0]), b = glm::dot(axis, corners[1]), c = glm::dot(axis, corners[2]);
        const double reach = glm::dot(half, glm::abs(axis));
        return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
    };
    for (int k = 0; k < 3; ++k) {
        glm::dvec3 axis(0.0);
        axis[k] = 1.0;
        if (apart(axis)) return false;
        for (const glm::dvec3& side : sides)
            if (apart(glm::cross(axis, side))) return false;
    }
    return !apart(glm::cross(sides[0], sides[1]));
}

// Of the directions to the sides, edges and corners of a cube: the one that is farthest from being opposite to any of
// the points, seen from the origin.
glm::dvec3 away_from_opposites(std::span<const glm::dvec3> points) {
    glm::dvec3 best(1.0, 0.0, 0.0);
    double best_worst = 2.0;
    for (int code = 0; code < 27; ++code) {
        if (code == 13) continue;
        const glm::dvec3 along = glm::normalize(glm::dvec3(code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1));
        double worst = -1.0; // cosine of the angle to the opposite direction
        for (const glm::dvec3& p : points) worst = std::max(worst, -glm::dot(along, p) / glm::length(p));
        if (worst < best_worst) {
            best_worst = worst;
            best = along;
        }
    }
    return best;
}

} // namespace

std::vector<std::vector<uint32_t>> border_loops(std::span<const Triangle> outer, std::span<const uint8_t> inner) {
    const HalfEdges edges(outer);
    std::unordered_set<uint64_t> taken;
    std::vector<std::vector<uint32_t>> loops;
    for (const Triangle& t : outer)
        for (int k = 0; k < 3; ++k) {
            uint32_t from = t[k], to = t[(k + 1) % 3];
            if (inner[from] || inner[to] || edges.contains(to, from) || taken.contains(key(from, to))) continue;
            std::vector<uint32_t>& loop = loops.emplace_back();
            while (taken.insert(key(from, to)).second) {
                loop.push_back(from);
                const uint32_t next = edges.end_of_next(from, to);
                from = to;
                to = next;
            }
        }
    return loops;
}

bool add_lids(TriangleMesh& patch, std::span<const std::vector<uint32_t>> border, const Box& region,
              std::vector<uint32_t>& original) {
    const glm::dvec3 centre = region.centre(), half = (0.5 + margin) * region.size();
    const size_t own = patch.triangles.size();
    double size = glm::length(half);
    for (const glm::dvec3& p : patch.positions) size = std::max(size, glm::distance(p, centre));
    const auto count = static_cast<uint32_t>(patch.positions.size());
    bool pinched = false;
    std::vector<uint8_t> seen(count, 0);
    for (const std::vector<uint32_t>& loop : border) {
        std::vector<glm::dvec3> arms;
        for (const uint32_t v : loop) {
            pinched = pinched || seen[v];
            seen[v] = 1;
            arms.push_back(strip_length * (patch.positions[v] - centre));
        }
        const auto first = static_cast<uint32_t>(patch.positions.size());
        const auto length = static_cast<uint32_t>(loop.size());
        for (const glm::dvec3& arm : arms) patch.positions.push_back(centre + arm);
        patch.positions.push_back(centre + apex_distance * strip_length * size * away_from_opposites(arms));
        for (uint32_t k = 0; k < length; ++k) {
            const uint32_t next = (k + 1) % length;
            const uint32_t a = loop[k], b = loop[next], far_a = first + k, far_b = first + next;
            patch.triangles.emplace_back(b, a, far_a);
            patch.triangles.emplace_back(b, far_a, far_b);
            patch.triangles.emplace_back(far_b, far_a, first + length);
        }
    }
    for (size_t t = own; t < patch.triangles.size(); ++t) {
        const Triangle& c = patch.triangles[t];
        const std::array corners{patch.positions[c.x] - centre, patch.positions[c.y] - centre,
                                 patch.positions[c.z] - centre};
        if (may_meet(corners, half)) return false;
    }
    original.assign(patch.positions.size(), no_index);
    for (uint32_t v = 0; v < count; ++v) original[v] = v;
    if (!pinched) return true;
    // The border touches itself in a vertex: each fan of triangles gets a vertex of its own.
    const TriangleMesh split = split_fans(patch);
    std::vector<uint32_t> from(split.positions.size(), no_index);
    for (size_t t = 0; t < split.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) from[split.triangles[t][k]] = original[patch.triangles[t][k]];
    original = std::move(from);
    patch = split;
    return true;
}

void add_boxes(TriangleMesh& mesh, int count) {
    for (int k = 0; k < std::abs(count); ++k) {
        const Box box = bounds(mesh);
        const glm::dvec3 centre = box.centre(), half = glm::dvec3(0.75 * glm::length(box.size()));
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        for (uint32_t corner = 0; corner < 8; ++corner)
            mesh.positions.push_back(
                centre + half * glm::dvec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1));
        constexpr std::array<std::array<uint32_t, 4>, 6> faces{
            {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
        for (const auto& [a, b, c, d] : faces)
            for (Triangle t : {Triangle(a, b, c), Triangle(a, c, d)}) {
                if (count < 0) std::swap(t.y, t.z);
                mesh.triangles.push_back(t + first);
            }
    }
}

} // namespace brittle::fracture
