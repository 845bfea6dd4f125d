// What the solver's sweeps run over, and what that is made of.
#pragma once

#include <array>
#include <cstdint>

#include <btBulletDynamicsCommon.h>

namespace brittle::physics {

// Contacts that were closing faster than this, in m/s, are blows. The next step's solution starts from the impulses of the
// last one's, and what stopped a blow is a hundred times what will be needed: what the sweeps do not get rid of
// would be energy from nothing.
inline constexpr float blow_speed = 0.2f;

// Of a contact or of its friction. Vectors lie without gaps; four floats can be read at each. Bullet's units.
struct Row {
    float normal[3];            // from b to a
    float arm_a[3], arm_b[3];   // arm x normal; of b with -normal
    float turn_a[3], turn_b[3]; // what a unit of impulse does to the angular velocity
    float wanted;               // impulse that brings the velocity that is wanted, from that before the sweeps
    float gain;                 // impulse a unit of velocity
    float impulse;
    float light_a, light_b; // inverse masses
    uint32_t a, b;          // movers; where one body never moves it is b, and not to be looked at
};

// Four rows side by side whose b never moves.
using Four = std::array<float, 4>;
struct FourRows {
    std::array<Four, 3> normal, arm, turn;
    Four wanted, gain, impulse;
};

// What rows are made of: a body as it enters the solution.
struct Mover {
    btVector3 turning[3]{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};        // rows of the inverse inertia, in the world's axes
    btVector3 centre{0, 0, 0}, linear{0, 0, 0}, angular{0, 0, 0}; // gravity is in
    float light = 0.0f; // inverse mass; 0 of a body that rests, as its inertia is
};

// How velocities have changed so far; the last of four is 0.
struct Motion {
    float linear[4], angular[4];
};

} // namespace brittle::physics
