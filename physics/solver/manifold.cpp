#include "physics/solver/manifold.h"

#include <algorithm>

#include "physics/solver/bearing_points.h"

namespace brittle::physics {

namespace {

// Distance at which a contact begins and ends, as a part of the body's rotation radius.
constexpr float breaking_part = 0.02f;

} // namespace

Manifold::Manifold(const Body& a, const Body& b) : a_(&a), b_(&b) {
    const float radius = std::min(a.rotation_radius(), b.rotation_radius());
    breaking_threshold_ = breaking_part * radius;
    slop_ = slop_part * radius;
}

ContactPoint Manifold::point_at(const glm::vec3& normal, const glm::vec3& on_b, float distance) const {
    ContactPoint point;
    point.on_a = on_b + normal * distance;
    point.on_b = on_b;
    point.local_a = a_->frame.to_local(point.on_a);
    point.local_b = b_->frame.to_local(point.on_b);
    point.normal = normal;
    point.local_normal = normal * a_->frame.basis;
    point.distance = distance;
    return point;
}

void Manifold::replace(std::span<ContactPoint> candidates) {
    if (candidates.size() > max_points) {
        find_bearing(
            candidates, [](const ContactPoint& p) { return -p.distance; }, [](const ContactPoint& p) { return p.on_b; },
            [](const ContactPoint& p) { return p.normal; });
        candidates = candidates.first(max_points);
    }
    std::array<bool, max_points> continued{};
    const auto inherit = [&](ContactPoint& point, size_t old) {
        continued[old] = true;
        point.last = points_[old].last;
        point.start = points_[old].start;
    };
    std::array<bool, max_points> known{};
    for (size_t i = 0; i < candidates.size(); ++i)
        for (size_t old = 0; old < count_ && candidates[i].feature != no_feature; ++old)
            if (!continued[old] && points_[old].feature == candidates[i].feature) {
                inherit(candidates[i], old);
                known[i] = true;
                break;
            }
    for (size_t i = 0; i < candidates.size(); ++i) {
        if (known[i]) continue;
        float nearest = breaking_threshold_ * breaking_threshold_;
        size_t place = count_;
        for (size_t old = 0; old < count_; ++old)
            if (const float square = length_squared(points_[old].local_a - candidates[i].local_a);
                !continued[old] && square < nearest) {
                nearest = square;
                place = old;
            }
        if (place < count_) inherit(candidates[i], place);
    }
    count_ = static_cast<uint32_t>(candidates.size());
    std::ranges::copy(candidates, points_.begin());
}

void Manifold::refresh() {
    for (ContactPoint& point : points()) {
        point.on_a = a_->frame * point.local_a;
        point.on_b = b_->frame * point.local_b;
        point.normal = a_->frame.basis * point.local_normal;
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
