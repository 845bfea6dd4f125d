#include "fracture/mesh/inside.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace brittle::fracture {

namespace {

constexpr uint32_t max_bins = 512;

// Returns 1 or -1: the side of the line ab, seen along X, on which p lies. Swapping a and b negates the result exactly,
// so two triangles agree about their common edge. A point on the line is to the left of an edge that points upwards.
int side(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& p) {
    const bool swapped = b.y < a.y || (b.y == a.y && b.z < a.z);
    const glm::dvec3 &from = swapped ? b : a, &to = swapped ? a : b;
    const double cross = (to.y - from.y) * (p.z - from.z) - (to.z - from.z) * (p.y - from.y);
    return (cross >= 0.0) != swapped ? 1 : -1;
}

} // namespace

InsideTest::InsideTest(const TriangleMesh& mesh) : mesh_(mesh), box_(bounds(mesh)) {
    bins_ =
        std::clamp(static_cast<uint32_t>(std::sqrt(static_cast<double>(mesh.triangles.size()) / 2.0)), 1u, max_bins);
    begin_.assign(size_t{bins_} * bins_ + 1, 0);
    // Bins grow with coordinates, so those of its corners bound those of a triangle.
    std::vector<std::array<uint32_t, 2>> bin_of_vertex;
    bin_of_vertex.reserve(mesh.positions.size());
    for (const glm::dvec3& p : mesh.positions) bin_of_vertex.push_back({bin_of(p.y, 1), bin_of(p.z, 2)});
    const auto for_bins = [&](const Triangle& t, const auto& visit) {
        const auto &a = bin_of_vertex[t.x], &b = bin_of_vertex[t.y], &c = bin_of_vertex[t.z];
        const uint32_t y1 = std::max({a[0], b[0], c[0]}), z1 = std::max({a[1], b[1], c[1]});
        for (uint32_t y = std::min({a[0], b[0], c[0]}); y <= y1; ++y)
            for (uint32_t z = std::min({a[1], b[1], c[1]}); z <= z1; ++z) visit(y * bins_ + z);
    };
    for (const Triangle& t : mesh.triangles) for_bins(t, [&](uint32_t bin) { ++begin_[bin + 1]; });
    for (size_t k = 1; k < begin_.size(); ++k) begin_[k] += begin_[k - 1];
    members_.resize(begin_.back());
    std::vector<uint32_t> cursor(begin_.begin(), begin_.end() - 1);
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for_bins(mesh.triangles[t], [&](uint32_t bin) { members_[cursor[bin]++] = t; });
}

uint32_t InsideTest::bin_of(double at, int axis) const {
    const double size = box_.max[axis] - box_.min[axis];
    if (!(size > 0.0)) return 0;
    return static_cast<uint32_t>(std::clamp((at - box_.min[axis]) / size * bins_, 0.0, bins_ - 1.0));
}

bool InsideTest::operator()(const glm::dvec3& p) const {
    for (int k = 0; k < 3; ++k)
        if (!(p[k] >= box_.min[k] && p[k] <= box_.max[k])) return false;
    const uint32_t bin = bin_of(p.y, 1) * bins_ + bin_of(p.z, 2);
    int winding = 0;
    for (uint32_t k = begin_[bin]; k < begin_[bin + 1]; ++k) {
        const Triangle& t = mesh_.triangles[members_[k]];
        const glm::dvec3 &a = mesh_.positions[t.x], &b = mesh_.positions[t.y], &c = mesh_.positions[t.z];
        const int s = side(a, b, p);
        if (side(b, c, p) != s || side(c, a, p) != s) continue;
        // The line of the ray crosses the triangle. The crossing is ahead or behind by the side of the triangle's plane
        // on which p lies.
        const glm::dvec3 u = b - a, v = c - a, w = p - a;
        const double behind =
            w.x * (u.y * v.z - u.z * v.y) + w.y * (u.z * v.x - u.x * v.z) + w.z * (u.x * v.y - u.y * v.x);
        if (behind * s < 0.0) winding += s;
    }
    return winding > 0;
}

} // namespace brittle::fracture
