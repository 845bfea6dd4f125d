#include "physics/cutting/running_bond.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace brittle::physics {

namespace {

constexpr double face_tolerance = 1e-6;   // of a half's size: a box that reaches less into a half does not include it
constexpr double max_index = 1e9;         // largest index of a half, counted from the corner
constexpr double min_halves = 4096.0;     // most halves to search; or, if more:
constexpr double halves_per_brick = 32.0; // halves to search for each brick that may come off

using Half = std::array<int64_t, 3>; // half a brick, by its indices in the lattice

// The first of the two halves of the brick that holds `half`.
Half first_of_brick(Half half, uint32_t along) {
    half[along] -= (half[0] + half[1] + half[2]) & 1;
    return half;
}

Half integers(const glm::dvec3& place) {
    return {static_cast<int64_t>(place.x), static_cast<int64_t>(place.y), static_cast<int64_t>(place.z)};
}

} // namespace

RunningBond fitted(const RunningBond& bond, const fracture::Box& box) {
    RunningBond result{bond.brick, box.min, bond.along};
    for (int k = 0; k < 3; ++k)
        if (const double size = box.size()[k]; size > 0.0)
            result.brick[k] = size / std::max(1.0, std::round(size / bond.brick[k]));
    return result;
}

BricksTaken bricks_near(const RunningBond& bond, const fracture::Box& box, const glm::dvec3& point, double radius,
                        uint32_t most, const std::function<bool(const glm::dvec3&)>& there) {
    if (!std::isfinite(radius) || !std::isfinite(point.x + point.y + point.z) || bond.along > 2) return {};
    glm::dvec3 size = bond.brick;
    size[static_cast<int>(bond.along)] *= 0.5;
    const auto place_of = [&](const glm::dvec3& p) { return glm::floor((p - bond.corner) / size); };
    const glm::dvec3 low = place_of(box.min + face_tolerance * size), high = place_of(box.max - face_tolerance * size);
    for (int k = 0; k < 3; ++k)
        if (!(size[k] > 0.0) || !(std::abs(low[k]) < max_index) || !(std::abs(high[k]) < max_index)) return {};
    if (first_of_brick(integers(low), bond.along) == first_of_brick(integers(high), bond.along)) return {};

    glm::dvec3 from = low, to = high;
    const double bound = std::max(min_halves, halves_per_brick * most);
    for (;; radius *= 0.8) {
        from = glm::max(low, place_of(point - radius));
        to = glm::min(high, place_of(point + radius));
        const glm::dvec3 count = glm::max(to - from + 1.0, glm::dvec3(0.0));
        if (count.x * count.y * count.z <= bound) break;
    }
    const auto middle = [&](const Half& half) {
        return bond.corner + (glm::dvec3(half[0], half[1], half[2]) + 0.5) * size;
    };
    std::vector<std::pair<double, Half>> near;
    const Half first = integers(from), last = integers(to);
    for (int64_t z = first[2]; z <= last[2]; ++z)
        for (int64_t y = first[1]; y <= last[1]; ++y)
            for (int64_t x = first[0]; x <= last[0]; ++x)
                if (const double distance = glm::distance(middle({x, y, z}), point); distance <= radius)
                    near.push_back({distance, {x, y, z}});
    std::ranges::sort(near);

    BricksTaken result;
    result.diagonal = glm::length(size);
    std::set<Half> taken, beside;
    for (const auto& [distance, half] : near) {
        if (result.bricks.size() == most) break;
        const Half one = first_of_brick(half, bond.along);
        Half other = one;
        ++other[bond.along];
        if (taken.contains(one) || !there(middle(half))) continue;
        taken.insert(one);
        taken.insert(other);
        result.bricks.push_back({middle(one), middle(other)});
    }
    for (const Half& half : taken)
        for (size_t axis = 0; axis < 3; ++axis)
            for (const int64_t step : {-1, 1}) {
                Half next = half;
                next[axis] += step;
                if (!taken.contains(next)) beside.insert(next);
            }
    for (const Half& half : beside) result.beside.push_back(middle(half));
    return result;
}

} // namespace brittle::physics
