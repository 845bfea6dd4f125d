#include "fracture/mending/fill_loop.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "fracture/plane_predicates.h"
#include "fracture/triangulate.h"

namespace brittle::fracture::mending {
namespace {

constexpr size_t most_corners_by_area = 128;
constexpr size_t most_corners_by_ears = 4096;

// Pairs of sides that are compared for a loop, at most, besides 64 a side.
constexpr size_t most_pairs = 4'000'000;

int sign(double x) {
    return x > 0.0 ? 1 : (x < 0.0 ? -1 : 0);
}

bool in_box(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& p) {
    for (int k = 0; k < 2; ++k)
        if (p[k] < std::min(a[k], b[k]) || p[k] > std::max(a[k], b[k])) return false;
    return true;
}

// Whether two closed segments have a point in common. Exact.
bool meet(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
    const int abc = sign(orientation(a, b, c)), abd = sign(orientation(a, b, d));
    const int cda = sign(orientation(c, d, a)), cdb = sign(orientation(c, d, b));
    if (abc * abd < 0 && cda * cdb < 0) return true;
    return (abc == 0 && in_box(a, b, c)) || (abd == 0 && in_box(a, b, d)) || (cda == 0 && in_box(c, d, a))
           || (cdb == 0 && in_box(c, d, b));
}

// No side touches another but at their common corner.
bool is_simple(const std::vector<glm::dvec2>& points) {
    const size_t n = points.size();
    const auto end = [&](size_t k) -> const glm::dvec2& { return points[k + 1 == n ? 0 : k + 1]; };
    for (size_t k = 0; k < n; ++k) {
        const glm::dvec2 &a = points[k], &b = end(k), &c = end(k + 1 == n ? 0 : k + 1);
        // A side without length, or one that runs back on the one before.
        if (a == b || (orientation(a, b, c) == 0.0 && glm::dot(b - a, c - b) <= 0.0)) return false;
    }
    std::vector<uint32_t> order(n);
    std::iota(order.begin(), order.end(), 0u);
    const auto least_x = [&](uint32_t k) { return std::min(points[k].x, end(k).x); };
    std::sort(order.begin(), order.end(), [&](uint32_t i, uint32_t j) {
        return least_x(i) != least_x(j) ? least_x(i) < least_x(j) : i < j;
    });
    size_t pairs = 0;
    for (size_t i = 0; i < n; ++i) {
        const glm::dvec2 &a = points[order[i]], &b = end(order[i]);
        for (size_t j = i + 1; j < n && least_x(order[j]) <= std::max(a.x, b.x); ++j) {
            if (++pairs > most_pairs + 64 * n) return false;
            const size_t apart = (size_t{order[i]} + n - order[j]) % n;
            if (apart == 1 || apart == n - 1) continue;
            const glm::dvec2 &c = points[order[j]], &d = end(order[j]);
            if (std::max(c.y, d.y) < std::min(a.y, b.y) || std::max(a.y, b.y) < std::min(c.y, d.y)) continue;
            if (meet(a, b, c, d)) return false;
        }
    }
    return true;
}

// How bad a triangulation is: taken edges first, then area or length.
struct Cost {
    uint32_t taken = 0;
    double size = 0.0;

    [[nodiscard]] bool operator<(const Cost& other) const {
        return taken != other.taken ? taken < other.taken : size < other.size;
    }
    [[nodiscard]] Cost operator+(const Cost& other) const { return {taken + other.taken, size + other.size}; }
};

constexpr uint32_t impossible = 1u << 30;

class Filler {
  public:
    Filler(std::span<const glm::dvec3> positions, std::span<const uint32_t> loop, const Taken& taken)
        : positions_(positions), loop_(loop), taken_(taken) {}

    Fill run() {
        const size_t n = loop_.size();
        std::vector<Triangle> flat = in_plane();
        const uint32_t flat_cost = taken_edges(flat);
        if (!flat.empty() && flat_cost == 0) return {std::move(flat)};
        if (n <= most_corners_by_area) {
            uint32_t cost = impossible;
            std::vector<Triangle> least = of_least_area(cost);
            return {!flat.empty() && flat_cost <= cost ? std::move(flat) : std::move(least)};
        }
        if (!flat.empty()) return {std::move(flat)};
        if (n > most_corners_by_ears) return {{}, true};
        return {by_ears()};
    }

  private:
    [[nodiscard]] const glm::dvec3& at(size_t k) const { return positions_[loop_[k]]; }
    [[nodiscard]] Triangle of(size_t i, size_t j, size_t k) const { return {loop_[i], loop_[j], loop_[k]}; }

    [[nodiscard]] bool are_neighbours(size_t i, size_t j) const {
        const size_t apart = i < j ? j - i : i - j;
        return apart == 1 || apart + 1 == loop_.size();
    }

    // Of triangles whose corners are numbers of corners of the loop: inner edges that are taken, counted from both sides.
    [[nodiscard]] uint32_t taken_edges(const std::vector<Triangle>& triangles) const {
        uint32_t count = 0;
        std::vector<uint32_t> number; // of the loop's corners, by vertex
        number.resize(loop_.size());
        std::iota(number.begin(), number.end(), 0u);
        std::sort(number.begin(), number.end(), [&](uint32_t a, uint32_t b) { return loop_[a] < loop_[b]; });
        const auto number_of = [&](uint32_t vertex) {
            return *std::lower_bound(number.begin(), number.end(), vertex,
                                     [&](uint32_t k, uint32_t v) { return loop_[k] < v; });
        };
        for (const Triangle& t : triangles)
            for (int k = 0; k < 3; ++k) {
                const uint32_t a = t[k], b = t[(k + 1) % 3];
                if (!are_neighbours(number_of(a), number_of(b)) && taken_.edge(a, b)) ++count;
            }
        return count / 2;
    }

    // Empty where the loop is not simple as seen along its normal, or a triangle is taken.
    [[nodiscard]] std::vector<Triangle> in_plane() const {
        const glm::dvec3 o = at(0);
        glm::dvec3 normal(0.0); // Newell's
        for (size_t k = 0; k < loop_.size(); ++k) normal += glm::cross(at(k) - o, at((k + 1) % loop_.size()) - o);
        const double largest = std::max({std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)});
        if (!(largest > 0.0) || !std::isfinite(largest)) return {};
        normal = glm::normalize(normal / largest);
        int least = 0;
        for (int k = 1; k < 3; ++k)
            if (std::abs(normal[k]) < std::abs(normal[least])) least = k;
        glm::dvec3 axis(0.0);
        axis[least] = 1.0;
        const glm::dvec3 u = glm::normalize(glm::cross(axis, normal)), v = glm::cross(normal, u);
        std::vector<glm::dvec2> points;
        for (size_t k = 0; k < loop_.size(); ++k) points.emplace_back(glm::dot(at(k) - o, u), glm::dot(at(k) - o, v));
        if (!is_simple(points)) return {};

        Loop corners(loop_.size());
        std::iota(corners.begin(), corners.end(), 0u);
        const Triangulation flat = triangulate(points, std::span(&corners, 1));
        if (flat.forced_ears > 0 || flat.triangles.size() != loop_.size() - 2) return {};
        std::vector<Triangle> triangles;
        for (const Triangle& t : flat.triangles) {
            triangles.push_back(of(t.x, t.y, t.z));
            if (taken_.triangle(triangles.back())) return {};
        }
        return triangles;
    }

    [[nodiscard]] Cost cost_of(size_t i, size_t j, size_t k) const {
        if (taken_.triangle(of(i, j, k))) return {impossible, 0.0};
        return {0, glm::length(glm::cross(at(j) - at(i), at(k) - at(i)))};
    }

    // The best of all triangulations, by those of parts of the loop (Klincsek 1980). Sets the number of taken edges.
    [[nodiscard]] std::vector<Triangle> of_least_area(uint32_t& taken) const {
        const size_t n = loop_.size();
        std::vector<Cost> cost(n * n); // of the part from i to j, at i n + j
        std::vector<uint32_t> middle(n * n, 0);
        for (size_t width = 2; width < n; ++width) {
            for (size_t i = 0; i + width < n; ++i) {
                const size_t j = i + width;
                Cost best{no_index, 0.0};
                for (size_t k = i + 1; k < j; ++k) {
                    const Cost parts = cost[i * n + k] + cost[k * n + j];
                    if (best < parts) continue;
                    const Cost whole = parts + cost_of(i, k, j);
                    if (!(whole < best)) continue;
                    best = whole;
                    middle[i * n + j] = static_cast<uint32_t>(k);
                }
                if (!are_neighbours(i, j) && taken_.edge(loop_[i], loop_[j])) ++best.taken;
                best.taken = std::min(best.taken, impossible);
                cost[i * n + j] = best;
            }
        }
        taken = cost[n - 1].taken;
        if (taken >= impossible) return {};
        std::vector<Triangle> triangles;
        std::vector<std::pair<size_t, size_t>> parts = {{0, n - 1}};
        while (!parts.empty()) {
            const auto [i, j] = parts.back();
            parts.pop_back();
            if (j - i < 2) continue;
            const size_t k = middle[i * n + j];
            triangles.push_back(of(i, k, j));
            parts.emplace_back(k, j);
            parts.emplace_back(i, k);
        }
        return triangles;
    }

    [[nodiscard]] std::vector<Triangle> by_ears() const {
        const auto cost_of_ear = [&](size_t i, size_t j, size_t k) {
            Cost cost{0, glm::distance(at(i), at(k))};
            if (taken_.triangle(of(i, j, k))) cost.taken = impossible;
            else if (taken_.edge(loop_[i], loop_[k])) cost.taken = 1;
            return cost;
        };
        std::vector<size_t> ring(loop_.size());
        std::iota(ring.begin(), ring.end(), size_t{0});
        std::vector<Cost> cost(ring.size());
        const auto before = [&](size_t k) { return ring[k == 0 ? ring.size() - 1 : k - 1]; };
        const auto after = [&](size_t k) { return ring[k + 1 == ring.size() ? 0 : k + 1]; };
        for (size_t k = 0; k < ring.size(); ++k) cost[k] = cost_of_ear(before(k), ring[k], after(k));
        std::vector<Triangle> triangles;
        while (ring.size() > 3) {
            const auto ear = static_cast<size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
            if (cost[ear].taken == impossible) return {};
            triangles.push_back(of(before(ear), ring[ear], after(ear)));
            ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
            cost.erase(cost.begin() + static_cast<std::ptrdiff_t>(ear));
            const size_t right = ear == ring.size() ? 0 : ear, left = right == 0 ? ring.size() - 1 : right - 1;
            cost[left] = cost_of_ear(before(left), ring[left], after(left));
            cost[right] = cost_of_ear(before(right), ring[right], after(right));
        }
        triangles.push_back(of(ring[0], ring[1], ring[2]));
        if (taken_.triangle(triangles.back())) return {};
        return triangles;
    }

    std::span<const glm::dvec3> positions_;
    std::span<const uint32_t> loop_;
    const Taken& taken_;
};

} // namespace

Fill fill_loop(std::span<const glm::dvec3> positions, std::span<const uint32_t> loop, const Taken& taken) {
    return Filler(positions, loop, taken).run();
}

} // namespace brittle::fracture::mending
