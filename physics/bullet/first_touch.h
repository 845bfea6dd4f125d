// When two hulls that move will first touch within a step, so that neither is inside the other when the step ends.
//
// Bullet finds contacts where hulls are, not on their way: at 2 m/s and 120 Hz a crumb moves by its own size in a step,
// starts the next one inside a shelf, and is pushed out on any side. Contacts made ahead of time would stop it, but give
// their impulse in two parts, a step apart, and a blow that breaks things must come whole. So a body that would run into
// another ends its step where they touch, with its velocity as it was; the next step finds the contact and all of its speed.
//
// Bullet's units.
#pragma once

#include <optional>

#include <btBulletDynamicsCommon.h>

namespace brittle::physics {

// A hull of a body, and where it is in the body's frame.
struct MovingHull {
    const btConvexHullShape* shape;
    btTransform local;
    btRigidBody* body;
};

// Two hulls of two bodies that may meet within a step. Closer than near they have a contact.
struct Meeting {
    MovingHull first, second;
    btScalar near;
};

// At most so fast the two hulls come closer: in any direction, and along one from second to first.
[[nodiscard]] btScalar closing_bound(const MovingHull& first, const MovingHull& second);
[[nodiscard]] btScalar closing_bound(const MovingHull& first, const MovingHull& second, const btVector3& direction);

// How deep the hulls may be in each other and still be told apart on the right side: a part of the thinner one.
[[nodiscard]] btScalar bearable_depth(const btConvexHullShape& first, const btConvexHullShape& second);

struct Touch {
    btScalar part;    // of the step, 0 .. 1
    btVector3 normal; // unit, from second to first
};

// When in the step they touch, by conservative advancement (Mirtich, 1996): both are moved on by
// the time that their distance needs at least, until they are nearer than near or the time is over. Nothing for hulls that
// are as near at once, nor for those that slide or graze so that they get no deeper than is bearable.
[[nodiscard]] std::optional<Touch> first_touch(const Meeting& meeting, btScalar seconds);

} // namespace brittle::physics
