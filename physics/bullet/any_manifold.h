// What a pair of bodies touches in: Bullet's manifold or, with the ground, one of ours.
#pragma once

#include <cstdint>

#include <btBulletDynamicsCommon.h>

#include "physics/bullet/ground_contact.h"

namespace brittle::physics {

// One of the two. The ground is the second of its pair.
struct AnyManifold {
    btPersistentManifold* bodies = nullptr;
    GroundManifold* ground = nullptr;

    [[nodiscard]] uint32_t count() const {
        return ground ? ground->count : static_cast<uint32_t>(bodies->getNumContacts());
    }
};

} // namespace brittle::physics
