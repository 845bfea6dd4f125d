#include "physics/solver/manifold.h"

#include <algorithm>

namespace brittle::physics {

namespace {

// Distance at which a contact begins and ends, as a part of the body's rotation radius.
constexpr float breaking_part = 0.02f;

} // namespace

Manifold::Manifold(const Body& a, const Body& b)
    : a_(&a), b_(&b), breaking_threshold_(breaking_part * std::min(a.rotation_radius(), b.rotation_radius())) {}

void Manifold::add(const glm::vec3& normal, const glm::vec3& on_b, float distance, uint32_t part_a, uint32_t part_b) {
    if (distance > breaking_threshold_) return;
    ContactPoint point;
    point.on_a = on_b + normal * distance;
    point.on_b = on_b;
    point.local_a = a_->frame.to_local(point.on_a);
    point.local_b = b_->frame.to_local(point.on_b);
    point.normal = normal;
    point.distance = distance;
    point.part_a = part_a;
    point.part_b = part_b;
    point.tangent = tangents_of(normal).first;
    // The nearest known point within the threshold is this contact.
    float nearest = breaking_threshold_ * breaking_threshold_;
    ContactPoint* same = nullptr;
    for (ContactPoint& known : points())
        if (const float square = length_squared(known.local_a - point.local_a); square < nearest) {
            nearest = square;
            same = &known;
        }
    if (!same) return add(point);
    point.normal_impulse = same->normal_impulse;
    point.friction_impulse = same->friction_impulse;
    *same = point;
}

void Manifold::add(const ContactPoint& point) {
    points_[count_ < max_points ? count_++ : place_of(point)] = point;
}

// Returns the index of the point that a fifth one replaces: the remaining four span the largest area and include the
// deepest of the five.
uint32_t Manifold::place_of(const ContactPoint& point) const {
    int deepest = -1; // the new one
    float depth = point.distance;
    for (int i = 0; i < 4; ++i)
        if (points_[static_cast<size_t>(i)].distance < depth) {
            deepest = i;
            depth = points_[static_cast<size_t>(i)].distance;
        }
    // The squared double area of the new point and three others: of the three pairs of opposite sides or diagonals, the
    // diagonals have the longest cross product.
    const auto area = [&](size_t i, size_t j, size_t k) {
        const glm::vec3 &a = points_[i].local_a, &b = points_[j].local_a, &c = points_[k].local_a;
        return std::max({length_squared(glm::cross(point.local_a - a, c - b)),
                         length_squared(glm::cross(point.local_a - b, c - a)),
                         length_squared(glm::cross(point.local_a - c, b - a))});
    };
    const std::array<float, 4> areas{deepest != 0 ? area(1, 2, 3) : 0.0f, deepest != 1 ? area(0, 2, 3) : 0.0f,
                                     deepest != 2 ? area(0, 1, 3) : 0.0f, deepest != 3 ? area(0, 1, 2) : 0.0f};
    return static_cast<uint32_t>(std::ranges::max_element(areas) - areas.begin());
}

void Manifold::refresh() {
    for (ContactPoint& point : points()) {
        point.on_a = a_->frame * point.local_a;
        point.on_b = b_->frame * point.local_b;
        point.distance = glm::dot(point.on_a - point.on_b, point.normal);
    }
    for (uint32_t i = count_; i-- > 0;) {
        const ContactPoint& point = points_[i];
        const glm::vec3 across = point.on_b - (point.on_a - point.normal * point.distance);
        if (point.distance <= breaking_threshold_
            && !(length_squared(across) > breaking_threshold_ * breaking_threshold_))
            continue;
        --count_;
        if (i != count_) points_[i] = points_[count_];
    }
}

} // namespace brittle::physics
