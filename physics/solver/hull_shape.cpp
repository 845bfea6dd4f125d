#include "physics/solver/hull_shape.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>

namespace brittle::physics {

void HullShape::finish() {
    const int count = getNumPoints();
    assert(count > 0);
    lanes_.assign(static_cast<size_t>((count + 3) / 4) * group_size, 0.0f);
    btScalar square = 0.0f;
    for (size_t place = 0; place < lanes_.size() / 3; ++place) {
        const btVector3& point = getUnscaledPoints()[std::min(static_cast<int>(place), count - 1)];
        for (size_t axis = 0; axis < 3; ++axis)
            lanes_[place / 4 * group_size + axis * 4 + place % 4] = point[static_cast<int>(axis)];
        square = std::max(square, point.length2());
    }
    radius_ = std::sqrt(square) + getMargin();
    btVector3 low, high;
    getAabb(btTransform::getIdentity(), low, high);
    const btVector3 size = high - low;
    longest_ = size[size.maxAxis()];
    motion_disc_ = size.length() * 0.5f + ((low + high) * 0.5f).length(); // as Bullet does
}

void HullShape::getAabb(const btTransform& frame, btVector3& low, btVector3& high) const {
    const btVector3 swollen(getMargin(), getMargin(), getMargin());
    std::array<Float4, 3> min_of, greatest_of;
    for (size_t axis = 0; axis < 3; ++axis)
        min_of[axis] = greatest_of[axis] = along(lanes_.data(), frame.getBasis()[static_cast<int>(axis)]);
    for (size_t at = group_size; at < lanes_.size(); at += group_size)
        for (size_t axis = 0; axis < 3; ++axis) {
            const Float4 there = along(lanes_.data() + at, frame.getBasis()[static_cast<int>(axis)]);
            min_of[axis] = min(min_of[axis], there);
            greatest_of[axis] = max(greatest_of[axis], there);
        }
    for (size_t axis = 0; axis < 3; ++axis) {
        low[static_cast<int>(axis)] = least(min_of[axis]);
        high[static_cast<int>(axis)] = greatest(greatest_of[axis]);
    }
    low += frame.getOrigin() - swollen;
    high += frame.getOrigin() + swollen;
}

btScalar HullShape::reach(const btVector3& direction) const {
    Float4 most = along(lanes_.data(), direction);
    for (size_t at = group_size; at < lanes_.size(); at += group_size)
        most = max(most, along(lanes_.data() + at, direction));
    return greatest(most);
}

int HullShape::farthest(const btVector3& direction) const {
    Float4 most = along(lanes_.data(), direction), group = Float4::all(0.0f);
    for (size_t at = group_size; at < lanes_.size(); at += group_size) {
        const Float4 there = along(lanes_.data() + at, direction);
        group = where_less(most, there, Float4::all(static_cast<float>(at / group_size)), group);
        most = max(most, there);
    }
    float groups[4];
    group.store(groups);
    int first = getNumPoints() - 1; // stays where the direction is not a number
    for (uint32_t lanes = equal(most, Float4::all(greatest(most))); lanes != 0; lanes &= lanes - 1) {
        const int lane = std::countr_zero(lanes);
        first = std::min(first, 4 * static_cast<int>(groups[lane]) + lane);
    }
    return first;
}

} // namespace brittle::physics
