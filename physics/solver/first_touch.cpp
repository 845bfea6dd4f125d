#include "physics/solver/first_touch.h"

#include <algorithm>

#include "physics/solver/convert.h"
#include "physics/solver/hull_distance.h"
#include "physics/solver/rotation.h"
#include "physics/world/hull.h"

namespace brittle::physics {

namespace {

// Hulls that meet flatly need two or three advances, corners that swing some more. What needs longer spins by several turns
// in the step; it is stopped where it is then, so that the cost of a pair is bounded.
constexpr int max_advances = 64;
// In margins of the thinner hull; a margin is a fiftieth of its thickness.
constexpr btScalar bearable_margins = 2.0f;
// Hulls are stopped between this part of the bearable depth and the whole of it: it ends.
constexpr btScalar stopped_part = 0.5f;
// The angular velocity of what tumbles is not constant; more than this it hardly grows within a step.
constexpr btScalar tumble = 1.25f;

struct Placed {
    btTransform first, second;
};

btScalar reach(const HullShape& hull, const btTransform& frame, const btVector3& direction) {
    return hull.reach(direction * frame.getBasis()) + direction.dot(frame.getOrigin());
}

// Between the hulls along a unit direction from second to first.
btScalar gap(const FlyingHull& first, const FlyingHull& second, const Placed& placed, const btVector3& normal) {
    return -reach(*first.shape, placed.first, -normal) - reach(*second.shape, placed.second, normal)
           - first.shape->getMargin() - second.shape->getMargin();
}

// How far a point of a hull may be from where it were if it moved on straight to where it is so much later.
btScalar sag(const FlyingHull& hull, btScalar seconds) {
    const btScalar radius = hull.local.getOrigin().length() + hull.shape->radius();
    const btScalar turn = tumble * hull.flight->angular.length() * std::min(seconds, hull.flight->stop);
    return radius * std::min<btScalar>(0.125f * turn * turn, 2.0f);
}

} // namespace

void Flight::find_end() {
    if (to_known == stop) return;
    to = stop > 0.0f ? on_way(stop) : from;
    to_known = stop;
}

btTransform Flight::on_way(btScalar seconds) const {
    const btVector3 origin = from.getOrigin() + linear * seconds;
    if (angular.isZero()) return btTransform(from.getBasis(), origin);
    const Spin spin = free_spin({glm::dquat(to_glm(from.getRotation())), glm::dvec3(to_glm(angular))}, moments,
                                static_cast<double>(seconds));
    return btTransform(to_bullet(glm::quat(spin.orientation)), origin);
}

btScalar thickness(const HullShape& hull) {
    return hull.getMargin() / HullSettings{}.margin_fraction;
}

btScalar bearable_depth(const HullShape& first, const HullShape& second) {
    return bearable_margins * std::min(first.getMargin(), second.getMargin());
}

std::optional<btScalar> first_touch(const FlyingHull& first, const FlyingHull& second, btScalar from, btScalar end) {
    const btScalar margins = first.shape->getMargin() + second.shape->getMargin();
    const btScalar bearable = bearable_depth(*first.shape, *second.shape);
    const Placed last{first.flight->at(end) * first.local, second.flight->at(end) * second.local};
    Placed now{first.flight->at(from) * first.local, second.flight->at(from) * second.local};
    btScalar time = from, deepest = -bearable;
    const auto last_gap = [&](const btVector3& normal) {
        return gap(first, second, last, normal) - sag(first, end - time) - sag(second, end - time);
    };
    // The direction from one to the other often tells that they pass, and saves the search.
    const btVector3 apart = now.first.getOrigin() - now.second.getOrigin();
    if (!apart.fuzzyZero()) {
        const btVector3 normal = apart.normalized();
        if (last_gap(normal) >= deepest && gap(first, second, now, normal) >= deepest) return std::nullopt;
    }
    NearCorners corners;
    for (int advance = 0; advance < max_advances; ++advance) {
        const HullDistance found =
            hull_distance(*first.shape, *second.shape, now.first.inverseTimes(now.second), BT_LARGE_FLOAT, corners);
        const btScalar distance = found.distance - margins;
        if (advance == 0) deepest += std::min<btScalar>(distance, 0.0f);
        if (distance - deepest <= (1.0f - stopped_part) * bearable) return time;
        const btScalar then = last_gap(now.first.getBasis() * found.normal);
        if (then >= deepest) return std::nullopt;
        time += (end - time) * (distance - deepest) / (distance - then);
        now = {first.flight->at(time) * first.local, second.flight->at(time) * second.local};
    }
    return time;
}

} // namespace brittle::physics
