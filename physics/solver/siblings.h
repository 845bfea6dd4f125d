// Pieces of one cut that come to the world together and fly as one.
//
// They do not overlap, by promise (BodyDesc::siblings). As long as none of them touches anything else and they move as one
// rigid body would, nothing can press between them, and their pairs need no look until two have moved against each other.
// A thousand pieces that come in the air then cost the first step a fifth of what it takes to find their contacts. Where one
// touches the ground or another body, or they move apart or into each other, they are pairs like all others.
//
// Bullet's second user index of a body holds its number for the body's first step, and otherwise Bullet's default.
#pragma once

#include <cassert>
#include <cstdint>
#include <optional>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include "physics/solver/sweep_broadphase.h"

namespace brittle::physics {

class Siblings {
  public:
    // What add() takes; on any thread.
    static void mark(btRigidBody& body, uint32_t number) { body.setUserIndex2(static_cast<int>(number)); }
    void add(btRigidBody& body) {
        assert(body.getUserIndex2() != none);
        bodies_.push_back(&body);
    }
    void remove(const btRigidBody& body);
    // Before pairs are looked at: lets only those go on as siblings that fly as one. Bullet's units; no height: no ground.
    void check(const SweptPairs& pairs, std::optional<btScalar> ground_height);
    // After the step.
    void forget();

    // While pairs are looked at.
    [[nodiscard]] static bool fly_as_one(const btCollisionObject& a, const btCollisionObject& b) {
        return a.getUserIndex2() != none && a.getUserIndex2() == b.getUserIndex2();
    }

  private:
    static constexpr int none = -1;

    std::vector<btRigidBody*> bodies_; // that have not been in a step
    std::vector<int> apart_;           // numbers of those that do not fly as one
};

} // namespace brittle::physics
