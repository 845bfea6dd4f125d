// Bodies that end their step where they touch another one, and not inside it: see first_touch.h.
#pragma once

#include <vector>

#include <btBulletDynamicsCommon.h>

#include "physics/bullet/first_touch.h"

namespace brittle::physics {

struct Stop {
    btRigidBody* body;
    btScalar part; // of its way in the step that it goes, 0 .. 1
};

// Adds to meetings those of bodies of several hulls, from pairs whose boxes overlap. Bullet looks at a compound's hulls only
// where they are now.
void find_compound_meetings(const btBroadphasePairArray& pairs, btScalar seconds, std::vector<Meeting>& meetings);

// Who stops, each body once, with the velocities that bodies have now. Of two that meet, whoever goes towards the other does.
// It goes on along its own way, never back, so that it does not go where its contacts forbid.
[[nodiscard]] std::vector<Stop> find_stops(const std::vector<Meeting>& meetings, btScalar seconds);

} // namespace brittle::physics
