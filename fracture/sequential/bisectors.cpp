#include "fracture/sequential/bisectors.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <utility>

#include "fracture/mesh/half_edge.h"
#include "fracture/sequential/clip.h"

namespace brittle::fracture {

namespace {

// A plane is kept when it comes nearer to a corner of the cell than this share of the size of the box around the site.
// Corners are computed from the box, so their rounding (1e-16) scales with the box, however small the cell is. The
// value is far above the rounding and far below the one that would cost time.
constexpr double prune_margin = 1e-9;

// The share of the coordinates in this margin, which matters far from the origin.
constexpr double coordinate_margin = 1e-14;

// The margin added to the box on each side, as a share of its diagonal, so that the mesh lies strictly inside.
constexpr double box_margin = 1e-3;

HalfEdgeMesh box_mesh(const Box& box) {
    std::array<glm::dvec3, 8> corner;
    for (int i = 0; i < 8; ++i)
        corner[i] = {(i & 1) ? box.max.x : box.min.x, (i & 2) ? box.max.y : box.min.y, (i & 4) ? box.max.z : box.min.z};
    static constexpr std::array<std::array<uint32_t, 4>, 6> quads{
        {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
    std::vector<Triangle> triangles;
    for (const auto& q : quads) {
        triangles.emplace_back(q[0], q[1], q[2]);
        triangles.emplace_back(q[0], q[2], q[3]);
    }
    Result<HalfEdgeMesh> mesh = build_half_edges(corner, triangles);
    assert(mesh && is_closed(*mesh));
    return *std::move(mesh);
}

double radius_around(const glm::dvec3& centre, std::span<const glm::dvec3> points) {
    double radius = 0.0;
    for (const glm::dvec3& p : points) radius = std::max(radius, glm::distance(centre, p));
    return radius;
}

// Whether a point of the convex hull of the corners may lie across the plane, or nearer to it than the margin (in m).
bool may_cut(const Bisector& plane, uint32_t site, std::span<const glm::dvec3> corners, double margin) {
    const double least = -margin * glm::length(plane.normal);
    return std::any_of(corners.begin(), corners.end(), [&](const glm::dvec3& corner) {
        const double towards_other = site == plane.low ? plane.value(corner) : -plane.value(corner);
        return towards_other >= least;
    });
}

} // namespace

Bisector bisector(std::span<const glm::dvec3> sites, uint32_t a, uint32_t b, std::span<const double> weights) {
    assert(a != b);
    const uint32_t low = std::min(a, b);
    const uint32_t high = std::max(a, b);
    glm::dvec3 normal = sites[high] - sites[low];
    glm::dvec3 midpoint = sites[low] * 0.5 + sites[high] * 0.5;
    if (!weights.empty()) midpoint += (weights[low] - weights[high]) / (2.0 * glm::dot(normal, normal)) * normal;
    int exponent = 0;
    std::frexp(std::max({std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)}), &exponent);
    for (int i = 0; i < 3; ++i) normal[i] = std::ldexp(normal[i], -exponent);
    return {low, high, normal, midpoint};
}

CellBounds cell_bounds(std::span<const glm::dvec3> sites, uint32_t site, const Box& box,
                       std::span<const double> weights) {
    // A heap of candidates with the nearest on top, because only few are used.
    using Candidate = std::pair<double, uint32_t>; // distance, site
    std::vector<Candidate> heap;
    heap.reserve(sites.size());
    for (uint32_t other = 0; other < sites.size(); ++other) {
        if (other == site) continue;
        if (sites[other] != sites[site])
            heap.emplace_back(glm::distance(sites[other], sites[site]), other);
        else if (weights.empty() || weights[other] == weights[site] ? other < site : weights[other] > weights[site])
            return {.empty = true, .bisectors = {}};
    }
    std::make_heap(heap.begin(), heap.end(), std::greater{});
    // The largest difference of weights: another site can win a corner although its squared distance to it is larger by
    // this amount.
    const double advantage = weights.empty() ? 0.0 : *std::max_element(weights.begin(), weights.end()) - weights[site];
    const auto farthest_rival = [&](double reach) { return reach + std::sqrt(reach * reach + advantage); };

    const glm::dvec3 widening(box_margin * glm::length(box.size()));
    HalfEdgeMesh cell = box_mesh({box.min - widening, box.max + widening});
    double radius = radius_around(sites[site], cell.positions);
    const double margin = prune_margin * radius + coordinate_margin * radius_around(glm::dvec3(0.0), cell.positions);
    CellBounds bounds;
    while (!heap.empty() && heap.front().first <= farthest_rival(radius + margin)) {
        const uint32_t other = heap.front().second;
        std::pop_heap(heap.begin(), heap.end(), std::greater{});
        heap.pop_back();
        const Bisector plane = bisector(sites, site, other, weights);
        if (!may_cut(plane, site, cell.positions, margin)) continue;
        bounds.bisectors.push_back(plane);
        cell = clip(cell, plane, site);
        if (cell.faces.empty()) return {.empty = true, .bisectors = {}};
        radius = radius_around(sites[site], cell.positions);
    }
    std::erase_if(bounds.bisectors,
                  [&](const Bisector& plane) { return !may_cut(plane, site, cell.positions, margin); });
    return bounds;
}

} // namespace brittle::fracture
