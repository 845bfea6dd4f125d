#include "fracture/doctor/mending/fill_loop.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include <glm/geometric.hpp>

#include "fracture/doctor/mending/fill_in_plane.h"

namespace brittle::fracture::mending {
namespace {

constexpr size_t max_corners_by_area = 64;
constexpr size_t max_corners_on_request = 256; // fill_by_area()
constexpr size_t max_corners_by_ears = 4096;

// The cost of a triangulation: the number of edges that exist already, then area or length.
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
        const Loop loop(loop_.begin(), loop_.end());
        std::vector<Triangle> flat = fill_in_plane(positions_, std::span(&loop, 1), taken_);
        const uint32_t flat_cost = taken_inside(flat, taken_);
        if (!flat.empty() && flat_cost == 0) return {std::move(flat)};
        if (n <= max_corners_by_area) {
            uint32_t cost = impossible;
            std::vector<Triangle> least = of_least_area(cost);
            return {!flat.empty() && flat_cost <= cost ? std::move(flat) : std::move(least)};
        }
        if (!flat.empty()) return {std::move(flat)};
        if (n > max_corners_by_ears) return {{}, true};
        return {by_ears()};
    }

    [[nodiscard]] std::vector<Triangle> by_area() const {
        uint32_t cost = impossible;
        return of_least_area(cost);
    }

  private:
    [[nodiscard]] const glm::dvec3& at(size_t k) const { return positions_[loop_[k]]; }
    [[nodiscard]] Triangle of(size_t i, size_t j, size_t k) const { return {loop_[i], loop_[j], loop_[k]}; }

    [[nodiscard]] bool are_neighbours(size_t i, size_t j) const {
        const size_t apart = i < j ? j - i : i - j;
        return apart == 1 || apart + 1 == loop_.size();
    }

    [[nodiscard]] Cost cost_of(size_t i, size_t j, size_t k) const {
        if (taken_.triangle(of(i, j, k))) return {impossible, 0.0};
        return {0, glm::length(glm::cross(at(j) - at(i), at(k) - at(i)))};
    }

    // Finds the triangulation of least cost by dynamic programming over parts of the loop (Klincsek 1980). Sets the
    // number of edges that exist already.
    [[nodiscard]] std::vector<Triangle> of_least_area(uint32_t& taken) const {
        const size_t n = loop_.size();
        std::vector<Cost> cost(n * n); // entry i n + j: the part from i to j
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
            if (taken_.triangle(of(i, j, k)))
                cost.taken = impossible;
            else if (taken_.edge(loop_[i], loop_[k]))
                cost.taken = 1;
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

std::vector<Triangle> fill_by_area(std::span<const glm::dvec3> positions, std::span<const uint32_t> loop,
                                   const Taken& taken) {
    if (loop.size() > max_corners_on_request) return {};
    return Filler(positions, loop, taken).by_area();
}

} // namespace brittle::fracture::mending
