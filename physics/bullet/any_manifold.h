// What a pair of bodies touches in: Bullet's manifold or, with the ground, one of ours.
#pragma once

#include <cstdint>

#include <btBulletDynamicsCommon.h>

#include "physics/bullet/ground_contact.h"

namespace brittle::physics {

// One of the two.
struct AnyManifold {
    btPersistentManifold* between = nullptr;
    GroundManifold* ground = nullptr;

    [[nodiscard]] uint32_t count() const {
        return ground ? ground->count : static_cast<uint32_t>(between->getNumContacts());
    }
};

} // namespace brittle::physics
