#include "physics/bullet/first_touch.h"

#include <algorithm>

#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <LinearMath/btTransformUtil.h>

namespace brittle::physics {

namespace {

// Hulls that meet flatly need two or three advances, corners that swing some more. What needs longer only grazes.
constexpr int most_advances = 16;
// Margins that hulls may overlap by, from their surfaces inwards. A margin is a fiftieth of the thickness (hull.h): an eighth
// of the thinner one.
constexpr btScalar bearable_margins = 6.0f;

struct Closest final : btDiscreteCollisionDetectorInterface::Result {
    btVector3 normal;
    btScalar distance = BT_LARGE_FLOAT;
    bool found = false;
    void setShapeIdentifiersA(int, int) override {}
    void setShapeIdentifiersB(int, int) override {}
    void addContactPoint(const btVector3& on_second, const btVector3&, btScalar depth) override {
        normal = on_second, distance = depth, found = true;
    }
};

btTransform moved(const MovingHull& hull, btScalar seconds) {
    btTransform to;
    btTransformUtil::integrateTransform(hull.body->getWorldTransform(), hull.body->getLinearVelocity(),
                                        hull.body->getAngularVelocity(), seconds, to);
    return to * hull.local;
}

Closest closest(const Meeting& meeting, btScalar seconds, btScalar farthest) {
    btVoronoiSimplexSolver simplex;
    btGjkPairDetector gjk(meeting.first.shape, meeting.second.shape, &simplex, nullptr);
    btGjkPairDetector::ClosestPointInput input;
    input.m_transformA = moved(meeting.first, seconds);
    input.m_transformB = moved(meeting.second, seconds);
    const btScalar reach = farthest + meeting.first.shape->getMargin() + meeting.second.shape->getMargin();
    input.m_maximumDistanceSquared = reach * reach;
    Closest result;
    gjk.getClosestPoints(input, result, nullptr);
    return result;
}

// By how much faster than its centre of mass a point of the hull can be.
btScalar turning_speed(const MovingHull& hull) {
    const btScalar farthest = hull.local.getOrigin().length() + hull.shape->getAngularMotionDisc();
    return hull.body->getAngularVelocity().length() * farthest;
}

btVector3 approach(const MovingHull& first, const MovingHull& second) {
    return second.body->getLinearVelocity() - first.body->getLinearVelocity();
}

} // namespace

btScalar closing_bound(const MovingHull& first, const MovingHull& second) {
    return approach(first, second).length() + turning_speed(first) + turning_speed(second);
}

btScalar closing_bound(const MovingHull& first, const MovingHull& second, const btVector3& direction) {
    return approach(first, second).dot(direction) + turning_speed(first) + turning_speed(second);
}

btScalar bearable_depth(const btConvexHullShape& first, const btConvexHullShape& second) {
    return bearable_margins * std::min(first.getMargin(), second.getMargin());
}

std::optional<Touch> first_touch(const Meeting& meeting, btScalar seconds) {
    const btScalar farthest = meeting.near + closing_bound(meeting.first, meeting.second) * seconds;
    btScalar time = 0.0f;
    for (int advance = 0; advance < most_advances; ++advance) {
        const Closest now = closest(meeting, time, farthest);
        if (!now.found) return std::nullopt; // too far to meet, or in each other already
        const btScalar closing = closing_bound(meeting.first, meeting.second, now.normal);
        if (now.distance <= meeting.near) {
            const bool deep = closing * (seconds - time) > bearable_depth(*meeting.first.shape, *meeting.second.shape);
            return time > 0.0f && deep ? std::optional(Touch{time / seconds, now.normal}) : std::nullopt;
        }
        if (closing <= 0.0f) return std::nullopt;
        time += (now.distance - 0.5f * meeting.near) / closing; // half of near is left: it ends
        if (time >= seconds) return std::nullopt;
    }
    return std::nullopt;
}

} // namespace brittle::physics
