// Contacts that were blows: what one body did to another in a step, as one.
//
// World coordinates, N s, J. Pure functions; in the order of the contacts.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "physics/world.h"

namespace brittle::physics {

struct BodyBlow {
    BodyId body;
    BodyId other;             // the default for the ground
    glm::vec3 point{0.0f};    // weighed by impulse
    glm::vec3 normal{0.0f};   // unit, towards the body
    float impulse = 0.0f;     // along the normal
    float energy = 0.0f;      // half of impulse times approach speed: what a dead blow turns into cracks and heat
    // The impulse as if something of a kilogram gave it: blows of more mass take longer (impact_seconds in material.h), as
    // the cube root of the mass that is stopped, impulse / speed.
    float sharp = 0.0f;
};

// Of contacts that came in faster than speed (m/s); a body that `wanted` refuses is hit by none.
[[nodiscard]] std::vector<BodyBlow> find_blows(std::span<const Contact> contacts, float speed,
                                               const std::function<bool(BodyId)>& wanted);

} // namespace brittle::physics
