#include "fracture/doctor/mending/fill_in_plane.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "fracture/arithmetic/plane_predicates.h"

namespace brittle::fracture::mending {
namespace {

// The maximum number of pairs of sides compared for a loop, in addition to 64 per side.
constexpr size_t max_pairs = 4'000'000;

int sign(double x) {
    return x > 0.0 ? 1 : (x < 0.0 ? -1 : 0);
}

bool in_box(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& p) {
    for (int k = 0; k < 2; ++k)
        if (p[k] < std::min(a[k], b[k]) || p[k] > std::max(a[k], b[k])) return false;
    return true;
}

// Whether two closed segments have a common point. Exact.
bool meet(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
    const int abc = sign(orientation(a, b, c)), abd = sign(orientation(a, b, d));
    const int cda = sign(orientation(c, d, a)), cdb = sign(orientation(c, d, b));
    if (abc * abd < 0 && cda * cdb < 0) return true;
    return (abc == 0 && in_box(a, b, c)) || (abd == 0 && in_box(a, b, d)) || (cda == 0 && in_box(c, d, a))
           || (cdb == 0 && in_box(c, d, b));
}

// Whether the loop is simple: sides touch at their common corners only. Each point links to the next one.
bool is_simple(const std::vector<glm::dvec2>& points, const std::vector<uint32_t>& next) {
    const size_t n = points.size();
    const auto end = [&](size_t k) -> const glm::dvec2& { return points[next[k]]; };
    for (size_t k = 0; k < n; ++k) {
        const glm::dvec2 &a = points[k], &b = end(k), &c = end(next[k]);
        // A side without length, or one that runs back along the side before.
        if (a == b || (orientation(a, b, c) == 0.0 && glm::dot(b - a, c - b) <= 0.0)) return false;
    }
    std::vector<uint32_t> order(n);
    std::iota(order.begin(), order.end(), 0u);
    const auto min_x = [&](uint32_t k) { return std::min(points[k].x, end(k).x); };
    std::sort(order.begin(), order.end(),
              [&](uint32_t i, uint32_t j) { return min_x(i) != min_x(j) ? min_x(i) < min_x(j) : i < j; });
    size_t pairs = 0;
    for (size_t i = 0; i < n; ++i) {
        const glm::dvec2 &a = points[order[i]], &b = end(order[i]);
        for (size_t j = i + 1; j < n && min_x(order[j]) <= std::max(a.x, b.x); ++j) {
            if (++pairs > max_pairs + 64 * n) return false;
            if (next[order[i]] == order[j] || next[order[j]] == order[i]) continue;
            const glm::dvec2 &c = points[order[j]], &d = end(order[j]);
            if (std::max(c.y, d.y) < std::min(a.y, b.y) || std::max(a.y, b.y) < std::min(c.y, d.y)) continue;
            if (meet(a, b, c, d)) return false;
        }
    }
    return true;
}

// A point lies in a plane when it is nearer to it than this share of the size of all loops' box.
constexpr double in_plane = 1e-9;
constexpr double normal_grid = 1e-6; // planes are found by normals and offsets rounded to these steps
constexpr double offset_grid = 1e-7; // as a share of the box

// The maximum number of loops in one plane that are compared with each other.
constexpr size_t max_loops = 64;

bool is_inside(const glm::dvec2& p, const std::vector<glm::dvec2>& polygon) {
    bool inside = false;
    for (size_t k = 0; k < polygon.size(); ++k) {
        const glm::dvec2 &a = polygon[k], &b = polygon[k + 1 == polygon.size() ? 0 : k + 1];
        if ((a.y > p.y) == (b.y > p.y)) continue;
        const bool is_right = (orientation(a, b, p) > 0.0) == (b.y > a.y); // the side passes to the right of the point
        inside = inside != is_right;
    }
    return inside;
}

struct FlatLoop {
    std::array<int64_t, 4> plane; // rounded; equal for both orientations
    uint32_t index;
    glm::dvec3 normal; // Newell's normal
};

std::optional<FlatLoop> as_flat(std::span<const glm::dvec3> positions, const Loop& loop, uint32_t index,
                                const Box& box) {
    const double diagonal = glm::length(box.size());
    const glm::dvec3 normal = normal_of(positions, loop);
    const double length = glm::length(normal);
    if (!(length > 0.0) || !std::isfinite(length)) return {};
    glm::dvec3 unit = normal / length;
    int largest = 0;
    for (int k = 1; k < 3; ++k)
        if (std::abs(unit[k]) > std::abs(unit[largest]) + 0.1) largest = k;
    if (unit[largest] < 0.0) unit = -unit;
    double least = glm::dot(positions[loop[0]] - box.min, unit), most = least;
    for (const uint32_t v : loop) {
        const double offset = glm::dot(positions[v] - box.min, unit);
        least = std::min(least, offset);
        most = std::max(most, offset);
    }
    if (most - least > in_plane * diagonal) return {};
    const auto rounded = [](double x) { return static_cast<int64_t>(std::floor(x + 0.5)); };
    return FlatLoop{{rounded(unit.x / normal_grid), rounded(unit.y / normal_grid), rounded(unit.z / normal_grid),
                     rounded(least / (offset_grid * diagonal))},
                    index,
                    normal};
}

// Finds the rings among the loops of one plane.
void find_rings_among(std::span<const glm::dvec3> positions, std::span<const Loop> loops, std::vector<FlatLoop> flat,
                      std::vector<std::vector<uint32_t>>& rings) {
    std::stable_sort(flat.begin(), flat.end(), [](const FlatLoop& a, const FlatLoop& b) {
        return glm::length(a.normal) > glm::length(b.normal);
    });
    const PlaneBasis basis(positions[loops[flat[0].index][0]], flat[0].normal);
    std::vector<std::vector<glm::dvec2>> polygons(flat.size());
    for (size_t k = 0; k < flat.size(); ++k)
        for (const uint32_t v : loops[flat[k].index]) polygons[k].push_back(basis(positions[v]));
    std::vector<std::vector<uint32_t>> ring(flat.size());
    std::vector<uint8_t> is_hole(flat.size(), 0);
    for (size_t k = 0; k < flat.size(); ++k) {
        ring[k] = {flat[k].index};
        for (size_t around = k; around-- > 0;) { // smallest loop first
            if (!is_inside(polygons[k][0], polygons[around])) continue;
            is_hole[k] = !is_hole[around] && glm::dot(flat[k].normal, flat[around].normal) < 0.0;
            if (is_hole[k]) ring[around].push_back(flat[k].index);
            break;
        }
    }
    for (std::vector<uint32_t>& r : ring)
        if (r.size() > 1) rings.push_back(std::move(r));
}

} // namespace

glm::dvec3 normal_of(std::span<const glm::dvec3> positions, const Loop& loop) {
    const glm::dvec3 o = positions[loop[0]];
    glm::dvec3 normal(0.0);
    for (size_t k = 1; k + 1 < loop.size(); ++k)
        normal += glm::cross(positions[loop[k]] - o, positions[loop[k + 1]] - o);
    return normal;
}

PlaneBasis::PlaneBasis(const glm::dvec3& origin, const glm::dvec3& normal) : origin_(origin) {
    const double largest = std::max({std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)});
    const glm::dvec3 n = glm::normalize(normal / largest);
    int least = 0;
    for (int k = 1; k < 3; ++k)
        if (std::abs(n[k]) < std::abs(n[least])) least = k;
    glm::dvec3 axis(0.0);
    axis[least] = 1.0;
    u_ = glm::normalize(glm::cross(axis, n));
    v_ = glm::cross(n, u_);
}

glm::dvec2 PlaneBasis::operator()(const glm::dvec3& p) const {
    return {glm::dot(p - origin_, u_), glm::dot(p - origin_, v_)};
}

std::vector<Triangle> fill_in_plane(std::span<const glm::dvec3> positions, std::span<const Loop> loops,
                                    const Taken& taken) {
    const glm::dvec3 normal = normal_of(positions, loops[0]);
    if (!(glm::length(normal) > 0.0) || !std::isfinite(glm::length(normal))) return {};
    const PlaneBasis basis(positions[loops[0][0]], normal);
    std::vector<glm::dvec2> points;
    std::vector<uint32_t> next, vertex; // per point
    std::vector<Loop> numbered;
    for (const Loop& loop : loops) {
        const auto first = static_cast<uint32_t>(points.size());
        numbered.emplace_back(loop.size());
        std::iota(numbered.back().begin(), numbered.back().end(), first);
        for (const uint32_t v : loop) {
            points.push_back(basis(positions[v]));
            vertex.push_back(v);
            next.push_back(static_cast<uint32_t>(points.size()));
        }
        next.back() = first;
    }
    if (!is_simple(points, next)) return {};
    const Triangulation flat = triangulate(points, numbered);
    if (flat.forced_ears > 0 || flat.triangles.size() != points.size() + 2 * loops.size() - 4) return {};
    std::vector<Triangle> triangles;
    for (const Triangle& t : flat.triangles) {
        triangles.emplace_back(vertex[t.x], vertex[t.y], vertex[t.z]);
        if (taken.triangle(triangles.back())) return {};
    }
    return triangles;
}

uint32_t taken_inside(const std::vector<Triangle>& triangles, const Taken& taken) {
    std::vector<std::pair<uint32_t, uint32_t>> edges;
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) edges.push_back(std::minmax({t[k], t[(k + 1) % 3]}));
    std::sort(edges.begin(), edges.end());
    uint32_t count = 0;
    for (size_t k = 1; k < edges.size(); ++k)
        if (edges[k] == edges[k - 1] && taken.edge(edges[k].first, edges[k].second)) ++count;
    return count;
}

std::vector<std::vector<uint32_t>> find_rings(std::span<const glm::dvec3> positions, std::span<const Loop> loops) {
    if (loops.size() < 2) return {};
    Box box{positions[loops[0][0]], positions[loops[0][0]]};
    for (const Loop& loop : loops) {
        for (const uint32_t v : loop) {
            box.min = glm::min(box.min, positions[v]);
            box.max = glm::max(box.max, positions[v]);
        }
    }
    std::vector<FlatLoop> flat;
    for (uint32_t k = 0; k < loops.size(); ++k)
        if (const auto loop = as_flat(positions, loops[k], k, box)) flat.push_back(*loop);
    std::sort(flat.begin(), flat.end(), [](const FlatLoop& a, const FlatLoop& b) {
        return a.plane != b.plane ? a.plane < b.plane : a.index < b.index;
    });
    std::vector<std::vector<uint32_t>> rings;
    for (size_t begin = 0, end = 0; begin < flat.size(); begin = end) {
        while (end < flat.size() && flat[end].plane == flat[begin].plane) ++end;
        if (end - begin < 2 || end - begin > max_loops) continue;
        find_rings_among(
            positions, loops,
            {flat.begin() + static_cast<std::ptrdiff_t>(begin), flat.begin() + static_cast<std::ptrdiff_t>(end)},
            rings);
    }
    return rings;
}

} // namespace brittle::fracture::mending
