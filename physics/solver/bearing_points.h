// The choice of the contact points that bear load best among all that were found.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "physics/solver/transform.h"

namespace brittle::physics {

// Swaps the point with the highest score among points[place] and later ones to `place`; the first of several.
template<class Point>
void take_best(std::span<Point> points, size_t place, const auto& score) {
    size_t best = place;
    float most = score(points[place]);
    for (size_t i = place + 1; i < points.size(); ++i) {
        const float own = score(points[i]);
        if (most < own) {
            most = own;
            best = i;
        }
    }
    std::swap(points[place], points[best]);
}

// Moves four points to the front: the deepest, the one farthest from it, the one farthest from the line through both,
// and the one farthest on that line's other side, seen along the normal of the first. Precondition: there are at least
// four.
template<class Point>
void find_bearing(std::span<Point> points, const auto& depth_of, const auto& position_of, const auto& normal_of) {
    take_best(points, 0, depth_of);
    const glm::vec3 first = position_of(points[0]), normal = normal_of(points[0]);
    take_best(points, 1, [&](const Point& p) { return length_squared(position_of(p) - first); });
    const glm::vec3 line = position_of(points[1]) - first;
    const auto side = [&](const Point& p) { return glm::dot(glm::cross(line, position_of(p) - first), normal); };
    take_best(points, 2, [&](const Point& p) { return std::abs(side(p)); });
    const float sign = side(points[2]) > 0.0f ? -1.0f : 1.0f;
    take_best(points, 3, [&](const Point& p) { return sign * side(p); });
}

} // namespace brittle::physics
