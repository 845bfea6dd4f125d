#include "fracture/doctor/mending/nesting.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <glm/geometric.hpp>

namespace brittle::fracture::mending {
namespace {

constexpr uint32_t max_samples = 8; // sample points per part
constexpr uint32_t max_bins = 512;  // along Y and Z each
constexpr size_t max_members = 16;  // average number of bins that hold a triangle

// Samples lie this share of the diagonal before and behind the surface, so that a point on another surface is seen both
// inside and outside of it.
constexpr double off_surface = 1e-9;

// The side of the line ab, in projection along X, on which the point lies. Two triangles agree about their common edge.
int side(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& p) {
    const bool swapped = b.y < a.y || (b.y == a.y && b.z < a.z);
    const glm::dvec3 &from = swapped ? b : a, &to = swapped ? a : b;
    const double cross = (to.y - from.y) * (p.z - from.z) - (to.z - from.z) * (p.y - from.y);
    return (cross >= 0.0) != swapped ? 1 : -1;
}

// Rays along X through a grid of triangles, as in inside.h, but for each part on its own and by parity.
class Rays {
  public:
    Rays(const TriangleMesh& mesh, std::span<const uint32_t> part_of, std::span<const uint8_t> closed)
        : mesh_(mesh), part_of_(part_of), closed_(closed), box_(bounds(mesh)) {
        bins_ = std::clamp(static_cast<uint32_t>(std::sqrt(static_cast<double>(mesh.triangles.size()) / 2.0)), 1u,
                           max_bins);
        while (bins_ > 1 && member_count() > max_members * mesh.triangles.size()) bins_ /= 2;
        begin_.assign(size_t{bins_} * bins_ + 1, 0);
        for_members([&](uint32_t, uint32_t bin) { ++begin_[bin + 1]; });
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        members_.resize(begin_.back());
        std::vector<uint32_t> cursor(begin_.begin(), begin_.end() - 1);
        for_members([&](uint32_t t, uint32_t bin) { members_[cursor[bin]++] = t; });
    }

    // The parts around the point, in ascending order.
    [[nodiscard]] std::vector<uint32_t> around(const glm::dvec3& p) const {
        std::vector<uint32_t> passed;
        const uint32_t bin = bin_of(p.y, 1) * bins_ + bin_of(p.z, 2);
        for (uint32_t k = begin_[bin]; k < begin_[bin + 1]; ++k)
            if (passes(mesh_.triangles[members_[k]], p)) passed.push_back(part_of_[members_[k]]);
        std::sort(passed.begin(), passed.end());
        std::vector<uint32_t> parts;
        for (size_t begin = 0, end = 0; begin < passed.size(); begin = end) {
            while (end < passed.size() && passed[end] == passed[begin]) ++end;
            if ((end - begin) % 2 == 1) parts.push_back(passed[begin]);
        }
        return parts;
    }

  private:
    template<class Visit>
    void for_members(const Visit& visit) const {
        for (uint32_t t = 0; t < part_of_.size(); ++t) {
            if (!closed_[part_of_[t]]) continue;
            const Range range = range_of(mesh_.triangles[t]);
            for (uint32_t y = range.y0; y <= range.y1; ++y)
                for (uint32_t z = range.z0; z <= range.z1; ++z) visit(t, y * bins_ + z);
        }
    }

    struct Range {
        uint32_t y0, y1, z0, z1;
    };

    [[nodiscard]] Range range_of(const Triangle& t) const {
        const glm::dvec3 &a = mesh_.positions[t.x], &b = mesh_.positions[t.y], &c = mesh_.positions[t.z];
        return {bin_of(std::min({a.y, b.y, c.y}), 1), bin_of(std::max({a.y, b.y, c.y}), 1),
                bin_of(std::min({a.z, b.z, c.z}), 2), bin_of(std::max({a.z, b.z, c.z}), 2)};
    }

    [[nodiscard]] size_t member_count() const {
        size_t sum = 0;
        for (const Triangle& t : mesh_.triangles) {
            const Range range = range_of(t);
            sum += size_t{range.y1 - range.y0 + 1} * (range.z1 - range.z0 + 1);
        }
        return sum;
    }

    [[nodiscard]] uint32_t bin_of(double at, int axis) const {
        const double size = box_.max[axis] - box_.min[axis];
        if (!(size > 0.0)) return 0;
        return static_cast<uint32_t>(std::clamp((at - box_.min[axis]) / size * bins_, 0.0, bins_ - 1.0));
    }

    // Whether the ray from the point towards larger X crosses the triangle.
    [[nodiscard]] bool passes(const Triangle& t, const glm::dvec3& p) const {
        const glm::dvec3 &a = mesh_.positions[t.x], &b = mesh_.positions[t.y], &c = mesh_.positions[t.z];
        const int s = side(a, b, p);
        if (side(b, c, p) != s || side(c, a, p) != s) return false;
        const glm::dvec3 normal = glm::cross(b - a, c - a);
        return glm::dot(normal, p - a) * s < 0.0;
    }

    const TriangleMesh& mesh_;
    std::span<const uint32_t> part_of_;
    std::span<const uint8_t> closed_;
    Box box_;
    uint32_t bins_ = 1;
    std::vector<uint32_t> begin_, members_;
};

} // namespace

std::vector<uint32_t> nesting_depths(const TriangleMesh& mesh, std::span<const uint32_t> part_of,
                                     std::span<const uint8_t> closed) {
    std::vector<uint32_t> depth(closed.size(), 0);
    if (std::count(closed.begin(), closed.end(), 1) < 2) return depth;
    const Rays rays(mesh, part_of, closed);
    const double off = off_surface * glm::length(bounds(mesh).size());

    std::vector<std::vector<uint32_t>> triangles(closed.size());
    for (uint32_t t = 0; t < part_of.size(); ++t)
        if (closed[part_of[t]]) triangles[part_of[t]].push_back(t);
    for (uint32_t part = 0; part < closed.size(); ++part) {
        // Parts around some sample, with no sample outside.
        std::vector<uint32_t> inside, possible;
        const size_t size = triangles[part].size();
        const size_t samples = std::min<size_t>(size, max_samples);
        bool first = true;
        for (size_t k = 0; k < samples; ++k) {
            const Triangle& t = mesh.triangles[triangles[part][k * size / samples]];
            const glm::dvec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
            const glm::dvec3 normal = glm::cross(b - a, c - a);
            const double length = glm::length(normal);
            if (!(length > 0.0)) continue;
            const glm::dvec3 middle = (a + b + c) / 3.0, step = normal * (off / length);
            const std::vector<uint32_t> before = rays.around(middle + step), behind = rays.around(middle - step);
            std::vector<uint32_t> either, merged;
            std::set_intersection(before.begin(), before.end(), behind.begin(), behind.end(),
                                  std::back_inserter(inside));
            std::set_union(before.begin(), before.end(), behind.begin(), behind.end(), std::back_inserter(either));
            if (first)
                merged = std::move(either);
            else
                std::set_intersection(possible.begin(), possible.end(), either.begin(), either.end(),
                                      std::back_inserter(merged));
            possible = std::move(merged);
            first = false;
        }
        std::sort(inside.begin(), inside.end());
        inside.erase(std::unique(inside.begin(), inside.end()), inside.end());
        for (const uint32_t other : possible)
            if (other != part && std::binary_search(inside.begin(), inside.end(), other)) ++depth[part];
    }
    return depth;
}

} // namespace brittle::fracture::mending
