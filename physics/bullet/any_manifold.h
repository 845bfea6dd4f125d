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
    // For who will look at its contacts: as many as most have. And a round later for who then looks at what lies on the ground.
    [[gnu::always_inline]] void fetch_contacts() const { fetch(ground ? static_cast<const void*>(ground) : between, 512); }
    [[gnu::always_inline]] void fetch_body() const {
        if (ground) fetch(ground->body, 448); // without what is of Bullet's own solver
    }
};

} // namespace brittle::physics
