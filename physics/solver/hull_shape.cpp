#include "physics/solver/hull_shape.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <utility>

namespace brittle::physics {

namespace {

// Writes vectors in groups of four; copies of the last one fill up the last group.
std::vector<float> in_lanes(std::span<const glm::vec3> vectors) {
    std::vector<float> lanes((vectors.size() + 3) / 4 * HullShape::group_size, 0.0f);
    for (size_t place = 0; place < lanes.size() / 3; ++place) {
        const glm::vec3& vector = vectors[std::min(place, vectors.size() - 1)];
        for (size_t axis = 0; axis < 3; ++axis)
            lanes[place / 4 * HullShape::group_size + axis * 4 + place % 4] = vector[static_cast<int>(axis)];
    }
    return lanes;
}

// Returns the index of the vector with the largest dot product with a direction; the lowest of several.
int farthest_along(std::span<const float> lanes, size_t count, const glm::vec3& direction) {
    Float4 most = HullShape::along(lanes.data(), direction), group = Float4::all(0.0f);
    for (size_t at = HullShape::group_size; at < lanes.size(); at += HullShape::group_size) {
        const Float4 there = HullShape::along(lanes.data() + at, direction);
        group = where_less(most, there, Float4::all(static_cast<float>(at / HullShape::group_size)), group);
        most = max(most, there);
    }
    float groups[4];
    group.store(groups);
    int first = static_cast<int>(count) - 1; // for a direction that is not a number
    for (uint32_t lanes_left = equal(most, Float4::all(max_of(most))); lanes_left != 0; lanes_left &= lanes_left - 1) {
        const int lane = std::countr_zero(lanes_left);
        first = std::min(first, 4 * static_cast<int>(groups[lane]) + lane);
    }
    return first;
}

// Twice the area of a loop, outwards.
glm::vec3 area_of(std::span<const glm::vec3> points, std::span<const uint16_t> loop) {
    glm::vec3 area(0.0f);
    const glm::vec3& apex = points[loop[0]];
    for (size_t i = 2; i < loop.size(); ++i) area += glm::cross(points[loop[i - 1]] - apex, points[loop[i]] - apex);
    return area;
}

} // namespace

HullShape::HullShape(std::vector<glm::vec3> points, float margin, HullFaces faces)
    : points_(std::move(points)), faces_(std::move(faces)), margin_(margin) {
    assert(!points_.empty());
    lanes_ = in_lanes(points_);
    float square = 0.0f;
    for (const glm::vec3& point : points_) square = std::max(square, length_squared(point));
    std::vector<glm::vec3> normals;
    normals.reserve(faces_.count());
    heights_.reserve((faces_.count() + 3) / 4 * 4);
    for (size_t face = 0; face < faces_.count(); ++face) {
        const glm::vec3 area = area_of(points_, faces_.of(face));
        const float length = glm::length(area), inverse = length > 0.0f ? 1.0f / length : 0.0f;
        const float wedge = glm::dot(area, points_[faces_.of(face)[0]]);
        normals.push_back(length > 0.0f ? area * inverse : glm::vec3(0.0f));
        heights_.push_back(wedge * inverse);
        volume_ += wedge / 6.0f;
    }
    if (!normals.empty()) normals_ = in_lanes(normals);
    while (heights_.size() % 4 != 0) heights_.push_back(heights_.back());
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
    return farthest_along(lanes_, points_.size(), direction);
}

int HullShape::face_along(const glm::vec3& direction) const {
    return normals_.empty() ? -1 : farthest_along(normals_, faces_.count(), direction);
}

glm::vec3 HullShape::normal_of(int face) const {
    const float* const group = &normals_[static_cast<size_t>(face) / 4 * group_size + static_cast<size_t>(face) % 4];
    return {group[0], group[4], group[8]};
}

bool HullShape::is_beyond(const glm::vec3& from, const glm::vec3& to, float by) const {
    const Float4 beyond = Float4::all(by);
    for (size_t first = 0; first < heights_.size(); first += 4) {
        const float* const group = normals_.data() + 3 * first;
        if (less(Float4::load(heights_.data() + first) + beyond, min(along(group, from), along(group, to))) != 0)
            return true;
    }
    return false;
}

float rotation_radius(const Bounds& bounds) {
    return glm::length(bounds.high - bounds.low) * 0.5f + glm::length((bounds.low + bounds.high) * 0.5f);
}

} // namespace brittle::physics
