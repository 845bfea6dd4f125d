#include "physics/solver/hull_shape.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <utility>

namespace brittle::physics {

HullShape::HullShape(std::vector<glm::vec3> points, float margin) : points_(std::move(points)), margin_(margin) {
    assert(!points_.empty());
    const size_t count = points_.size();
    lanes_.assign((count + 3) / 4 * group_size, 0.0f);
    float square = 0.0f;
    for (size_t place = 0; place < lanes_.size() / 3; ++place) {
        const glm::vec3& point = points_[std::min(place, count - 1)];
        for (size_t axis = 0; axis < 3; ++axis)
            lanes_[place / 4 * group_size + axis * 4 + place % 4] = point[static_cast<int>(axis)];
        square = std::max(square, length_squared(point));
    }
    radius_ = std::sqrt(square) + margin_;
    const Bounds box = bounds({});
    const glm::vec3 size = box.high - box.low;
    longest_ = std::max({size.x, size.y, size.z});
    rotation_radius_ = physics::rotation_radius(box);
}

Bounds HullShape::bounds(const Transform& frame) const {
    std::array<Float4, 3> low, high;
    for (size_t axis = 0; axis < 3; ++axis)
        low[axis] = high[axis] = along(lanes_.data(), row(frame.basis, static_cast<int>(axis)));
    for (size_t at = group_size; at < lanes_.size(); at += group_size)
        for (size_t axis = 0; axis < 3; ++axis) {
            const Float4 there = along(lanes_.data() + at, row(frame.basis, static_cast<int>(axis)));
            low[axis] = min(low[axis], there);
            high[axis] = max(high[axis], there);
        }
    const glm::vec3 margin(margin_);
    return {glm::vec3(min_of(low[0]), min_of(low[1]), min_of(low[2])) + (frame.origin - margin),
            glm::vec3(max_of(high[0]), max_of(high[1]), max_of(high[2])) + (frame.origin + margin)};
}

float HullShape::support(const glm::vec3& direction) const {
    Float4 most = along(lanes_.data(), direction);
    for (size_t at = group_size; at < lanes_.size(); at += group_size)
        most = max(most, along(lanes_.data() + at, direction));
    return max_of(most);
}

int HullShape::support_index(const glm::vec3& direction) const {
    Float4 most = along(lanes_.data(), direction), group = Float4::all(0.0f);
    for (size_t at = group_size; at < lanes_.size(); at += group_size) {
        const Float4 there = along(lanes_.data() + at, direction);
        group = where_less(most, there, Float4::all(static_cast<float>(at / group_size)), group);
        most = max(most, there);
    }
    float groups[4];
    group.store(groups);
    int first = point_count() - 1; // for a direction that is not a number
    for (uint32_t lanes = equal(most, Float4::all(max_of(most))); lanes != 0; lanes &= lanes - 1) {
        const int lane = std::countr_zero(lanes);
        first = std::min(first, 4 * static_cast<int>(groups[lane]) + lane);
    }
    return first;
}

float rotation_radius(const Bounds& bounds) {
    return glm::length(bounds.high - bounds.low) * 0.5f + glm::length((bounds.low + bounds.high) * 0.5f);
}

} // namespace brittle::physics
