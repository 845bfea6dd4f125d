#include "physics/bullet/step_stops.h"

#include <algorithm>

#include "physics/bullet/hull_contact.h"

namespace brittle::physics {

namespace {

int hull_count(const btRigidBody& body) {
    return body.getCollisionShape()->isCompound()
               ? static_cast<const btCompoundShape*>(body.getCollisionShape())->getNumChildShapes()
               : 1;
}

MovingHull hull_of(btRigidBody& body, int index) {
    if (!body.getCollisionShape()->isCompound())
        return {static_cast<const btConvexHullShape*>(body.getCollisionShape()), btTransform::getIdentity(), &body};
    const auto& compound = *static_cast<const btCompoundShape*>(body.getCollisionShape());
    return {static_cast<const btConvexHullShape*>(compound.getChildShape(index)), compound.getChildTransform(index), &body};
}

struct Ball {
    btVector3 centre;
    btScalar radius;
};
Ball ball_around(const MovingHull& hull) {
    btVector3 centre;
    btScalar radius = 0.0f;
    hull.shape->getBoundingSphere(centre, radius);
    return {hull.body->getWorldTransform() * (hull.local * centre), radius};
}

// Those of the two bodies' hulls whose balls may touch within the step.
void find_meetings(btRigidBody& first, btRigidBody& second, btScalar seconds, std::vector<Meeting>& meetings) {
    std::vector<std::pair<MovingHull, Ball>> others;
    for (int i = 0; i < hull_count(second); ++i) {
        const MovingHull hull = hull_of(second, i);
        others.emplace_back(hull, ball_around(hull));
    }
    for (int i = 0; i < hull_count(first); ++i) {
        const MovingHull hull = hull_of(first, i);
        const Ball ball = ball_around(hull);
        for (const auto& [other, other_ball] : others) {
            const btScalar way = closing_bound(hull, other) * seconds;
            const btScalar apart = (ball.centre - other_ball.centre).length() - ball.radius - other_ball.radius;
            if (way > std::max<btScalar>(apart, 0.0f) + bearable_depth(*hull.shape, *other.shape))
                meetings.push_back({hull, other, contact_distance(*hull.shape, *other.shape)});
        }
    }
}

btRigidBody& body_of(const btBroadphaseProxy* proxy) {
    return *btRigidBody::upcast(static_cast<btCollisionObject*>(proxy->m_clientObject));
}

} // namespace

void find_compound_meetings(const btBroadphasePairArray& pairs, btScalar seconds, std::vector<Meeting>& meetings) {
    for (int i = 0; i < pairs.size(); ++i) {
        btRigidBody& first = body_of(pairs[i].m_pProxy0);
        btRigidBody& second = body_of(pairs[i].m_pProxy1);
        if (!first.getCollisionShape()->isCompound() && !second.getCollisionShape()->isCompound()) continue;
        // The ground has contacts of its own that look ahead.
        if (first.getUserIndex() < 0 || second.getUserIndex() < 0) continue;
        if (first.isActive() || second.isActive()) find_meetings(first, second, seconds, meetings);
    }
}

std::vector<Stop> find_stops(const std::vector<Meeting>& meetings, btScalar seconds) {
    std::vector<Stop> stops;
    const auto stop = [&](btRigidBody& body, btScalar part) {
        if (body.isStaticObject() || !body.isActive()) return;
        const auto known = std::ranges::find(stops, &body, &Stop::body);
        if (known == stops.end())
            stops.push_back({&body, part});
        else
            known->part = std::min(known->part, part);
    };
    for (const Meeting& meeting : meetings) {
        const std::optional<Touch> touch = first_touch(meeting, seconds);
        if (!touch) continue;
        btRigidBody& first = *meeting.first.body;
        btRigidBody& second = *meeting.second.body;
        // How fast each goes towards the other. Who flees is followed as far as the two come closer before they touch.
        const btScalar of_first = -first.getLinearVelocity().dot(touch->normal);
        const btScalar of_second = second.getLinearVelocity().dot(touch->normal);
        const btScalar closing = touch->part * (of_first + of_second);
        if (of_second <= 0.0f && of_first > 0.0f)
            stop(first, std::clamp<btScalar>((closing - of_second) / of_first, 0.0f, 1.0f));
        else if (of_first <= 0.0f && of_second > 0.0f)
            stop(second, std::clamp<btScalar>((closing - of_first) / of_second, 0.0f, 1.0f));
        else {
            stop(first, touch->part);
            stop(second, touch->part);
        }
    }
    return stops;
}

} // namespace brittle::physics
