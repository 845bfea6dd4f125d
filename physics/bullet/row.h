// What the solver's sweeps run over.
#pragma once

#include <cstdint>

namespace brittle::physics {

// Of a contact or of its friction. Vectors lie without gaps; four floats can be read at each. Bullet's units.
struct Row {
    float normal[3];          // from b to a
    float arm_a[3], arm_b[3]; // arm x normal; of b with -normal
    float turn_a[3], turn_b[3]; // what a unit of impulse does to the angular velocity
    float wanted;             // impulse that brings the velocity that is wanted, from that before the sweeps
    float gain;               // impulse a unit of velocity
    float impulse;
    float light_a, light_b; // inverse masses
    uint32_t a, b;          // movers; where one body never moves it is b, and not to be looked at
};

// How velocities have changed so far; the last of four is 0.
struct Motion {
    float linear[4], angular[4];
};

} // namespace brittle::physics
