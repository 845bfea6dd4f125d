// When two hulls that move will first touch within a step.
//
// Hulls are compared where steps begin: at 2 m/s and 120 Hz a crumb moves by its own size in a step, is inside a shelf or
// behind it when it is next looked at, and is pushed out on any side. Here their distance is followed on their way.
//
// Between two moments each point moves on a straight line but for its turn, so the gap along one direction is a concave
// function of time but for the sag of that turn: it lies above its chord, and where that goes below the depth that is looked
// for is how far time may advance.
//
// Bullet's units, seconds. Thread-safe: no state.
//
// B. Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996, 2.3 (conservative advancement).
#pragma once

#include <optional>

#include <btBulletDynamicsCommon.h>
#include <glm/vec3.hpp>

#include "physics/solver/hull_shape.h"

namespace brittle::physics {

// A body on its way through a step, touching nothing: at its velocities until it stops, and from then on at rest.
struct Flight {
    btTransform from = btTransform::getIdentity(); // Bullet's frame when the step begins
    btVector3 linear{0, 0, 0}, angular{0, 0, 0};
    glm::dvec3 moments{1.0}; // principal
    btScalar stop = 0.0f;    // s from the step's beginning
    btTransform to = from;   // where it is then; see find_end()
    btScalar to_known = -1.0f;

    // Must be called before at(), and when stop has changed.
    void find_end();
    [[nodiscard]] btTransform at(btScalar seconds) const { return seconds >= stop ? to : on_way(seconds); }

  private:
    [[nodiscard]] btTransform on_way(btScalar seconds) const;
};

// A hull of a body, and where it is in the body's frame.
struct FlyingHull {
    const HullShape* shape;
    btTransform local;
    const Flight* flight;
};

// The least width of a hull, from its margin (hull.h).
[[nodiscard]] btScalar thickness(const HullShape& hull);

// How deep two hulls may be in each other and still be told apart on the right side: a part of the thinner one.
[[nodiscard]] btScalar bearable_depth(const HullShape& first, const HullShape& second);

// The time from `from` on until `end` at which they are about to be deeper in each other than is bearable, or deeper by that
// than they were: touching, with the contact still to be found. Nothing for hulls that only pass, however near, that slide
// on each other, or part. None of the two stops in between.
[[nodiscard]] std::optional<btScalar> first_touch(const FlyingHull& first, const FlyingHull& second, btScalar from,
                                                  btScalar end);

} // namespace brittle::physics
