#include "physics/solver/time_of_impact.h"

#include <algorithm>

#include "physics/solver/free_rotation.h"
#include "physics/solver/hull_distance.h"
#include "physics/world/hull.h"

namespace brittle::physics {

namespace {

// Hulls that meet face to face take two or three advances, swinging corners a few more. Hulls that take more than this
// rotate several times in the step; they stop at the time reached, which bounds the cost of a pair.
constexpr int max_advances = 64;
// The tolerable depth in margins of the thinner hull; a margin is a fiftieth of its thickness.
constexpr float tolerable_margins = 2.0f;
// The search ends between this part of the tolerable depth and the whole of it.
constexpr float stopped_part = 0.5f;
// The angular velocity of a tumbling body is not constant; it grows by less than this factor within a step.
constexpr float tumbling_factor = 1.25f;

struct Frames {
    Transform first, second;
};

// The gap between the hulls along a unit direction from the second to the first.
float gap(const MovingHull& first, const MovingHull& second, const Frames& at, const glm::vec3& normal) {
    return -support(*first.shape, at.first, -normal) - support(*second.shape, at.second, normal) - first.shape->margin()
           - second.shape->margin();
}

// A bound of the distance of a hull's points from the straight lines to their places after some time.
float sag(const MovingHull& hull, float seconds) {
    const float radius = glm::length(hull.local.origin) + hull.shape->radius();
    const float angle =
        tumbling_factor * glm::length(hull.trajectory->velocity.angular) * std::min(seconds, hull.trajectory->stop);
    return radius * std::min(0.125f * angle * angle, 2.0f);
}

} // namespace

void Trajectory::find_end() {
    if (end_known_for == stop) return;
    end = stop > 0.0f ? moving_at(stop) : start;
    end_known_for = stop;
}

Transform Trajectory::moving_at(float seconds) const {
    const glm::vec3 origin = start.origin + velocity.linear * seconds;
    if (velocity.angular == glm::vec3(0.0f)) return {start.basis, origin};
    const Spin spin = free_spin({glm::dquat(rotation_of(start.basis)), glm::dvec3(velocity.angular)}, moments,
                                static_cast<double>(seconds));
    return {matrix_of(glm::quat(spin.orientation)), origin};
}

float thickness(const HullShape& hull) {
    return hull.margin() / HullSettings{}.margin_fraction;
}

float tolerable_depth(const HullShape& first, const HullShape& second) {
    return tolerable_margins * std::min(first.margin(), second.margin());
}

std::optional<float> time_of_impact(const MovingHull& first, const MovingHull& second, float from, float end) {
    const float margins = first.shape->margin() + second.shape->margin();
    const float tolerable = tolerable_depth(*first.shape, *second.shape);
    const auto frames_at = [&](float time) {
        return Frames{first.trajectory->at(time) * first.local, second.trajectory->at(time) * second.local};
    };
    const Frames last = frames_at(end);
    Frames now = frames_at(from);
    float time = from, deepest = -tolerable;
    const auto last_gap = [&](const glm::vec3& normal) {
        return gap(first, second, last, normal) - sag(first, end - time) - sag(second, end - time);
    };
    // The direction between the hulls' origins often shows that they pass, which saves the search.
    constexpr float epsilon = std::numeric_limits<float>::epsilon();
    const glm::vec3 apart = now.first.origin - now.second.origin;
    if (length_squared(apart) >= epsilon * epsilon) {
        const glm::vec3 normal = apart * (1.0f / glm::length(apart));
        if (last_gap(normal) >= deepest && gap(first, second, now, normal) >= deepest) return std::nullopt;
    }
    NearestCorners corners;
    for (int advance = 0; advance < max_advances; ++advance) {
        const HullDistance found =
            hull_distance(*first.shape, *second.shape, now.first.to_local(now.second), unbounded, corners);
        const float distance = found.distance - margins;
        if (advance == 0) deepest += std::min(distance, 0.0f);
        if (distance - deepest <= (1.0f - stopped_part) * tolerable) return time;
        const float then = last_gap(now.first.basis * found.normal);
        if (then >= deepest) return std::nullopt;
        time += (end - time) * (distance - deepest) / (distance - then);
        now = frames_at(time);
    }
    return time;
}

} // namespace brittle::physics
