// What a pair of bodies touches in: Bullet's manifold or, with the ground, one of ours.
#pragma once

#include <cstdint>

#include <btBulletDynamicsCommon.h>

#include "physics/solver/fetch.h"
#include "physics/solver/ground_contact.h"

namespace brittle::physics {

// One of the two, with what most who go through them ask for: neither it nor a body need be looked at for that.
struct AnyManifold {
    static constexpr uint32_t nobody = UINT32_MAX;

    btPersistentManifold* between = nullptr;
    GroundManifold* ground = nullptr;
    uint32_t a = nobody, b = nobody; // user indices of its bodies; nobody: the ground
    bool a_moves = true, b_moves = false;
    uint32_t count = 0; // of points

    explicit AnyManifold(btPersistentManifold& of)
        : between(&of), a(index_of(*of.getBody0())), b(index_of(*of.getBody1())),
          a_moves(!of.getBody0()->isStaticObject()), b_moves(!of.getBody1()->isStaticObject()),
          count(static_cast<uint32_t>(of.getNumContacts())) {}
    explicit AnyManifold(GroundManifold& of) : ground(&of), a(index_of(*of.body)), count(of.count) {}

    // For who will look at its contacts; and, a round later, for who then looks at what touches the ground.
    [[gnu::always_inline]] void fetch_contacts() const {
        fetch(ground ? static_cast<const void*>(ground) : between, 512); // as many as most have
    }
    [[gnu::always_inline]] void fetch_body() const {
        if (ground) fetch(ground->body, 448); // all but what only Bullet's own solver asks for
    }

  private:
    static uint32_t index_of(const btCollisionObject& body) { return static_cast<uint32_t>(body.getUserIndex()); }
};

} // namespace brittle::physics
