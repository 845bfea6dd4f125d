// Contacts that are solved a second time, for the parts of a body that broke on them (Structure::update()).
//
// Projected Gauss-Seidel from zero impulses, inelastic and without friction: the cracks took the energy of a bounce.
// Each impulse reduces the kinetic energy that the bodies had before the contacts, so energy cannot rise. Contacts with
// a fixed body come last in each sweep, so that a sweep ends with nothing moving into what is fixed.
//
//     std::vector<RewoundContact> contacts = ...;  // impulses undone by World::rewind()
//     solve_rewound(world, contacts);              // sets velocities and RewoundContact::impulse
//
// World coordinates, SI units. The cost is linear in contacts: about 1 ms for 1,000. Deterministic.
#pragma once

#include <limits>
#include <span>

#include <glm/vec3.hpp>

#include "physics/world/world.h"

namespace brittle::physics {

struct RewoundContact {
    BodyId a{}, b{}; // a body that is not in the world is fixed: the ground
    glm::vec3 point{0.0f};
    glm::vec3 normal{0.0f}; // unit, from b towards a
    float closing = 0.0f;   // m/s, approach that is left, because it closes the gap within the step
    float max_impulse = std::numeric_limits<float>::infinity(); // N s, >= 0
    float impulse = 0.0f;                                       // N s, on a along the normal: the result
};

void solve_rewound(World& world, std::span<RewoundContact> contacts);

} // namespace brittle::physics
