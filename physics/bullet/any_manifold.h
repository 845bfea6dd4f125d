// What a pair of bodies touches in: Bullet's manifold or, with the ground, one of ours.
#pragma once

#include <cstdint>

#include <btBulletDynamicsCommon.h>

#include "physics/bullet/fetch.h"
#include "physics/bullet/ground_contact.h"

namespace brittle::physics {

// One of the two.
struct AnyManifold {
    btPersistentManifold* between = nullptr;
    GroundManifold* ground = nullptr;

    [[nodiscard]] uint32_t count() const {
        return ground ? ground->count : static_cast<uint32_t>(between->getNumContacts());
    }
    // For who will look at its contacts; and, a round later, for who then looks at what touches the ground.
    [[gnu::always_inline]] void fetch_contacts() const {
        fetch(ground ? static_cast<const void*>(ground) : between, 512); // as many as most have
    }
    [[gnu::always_inline]] void fetch_body() const {
        if (ground) fetch(ground->body, 448); // all but what only Bullet's own solver asks for
    }
};

} // namespace brittle::physics
