// Torque-free rotation of a rigid body, integrated by a rule that conserves angular momentum and energy.
//
// Bullet integrates the orientation with the velocity at one instant. Its gyroscopic term, one Newton iteration of an
// implicit Euler step, damps tumbling visibly (a splinter stops flipping) and turns the angular momentum; without the
// term the energy of a tumbling body grows without bound. The implicit midpoint rule costs no more.
//
// Radians, seconds. Pure functions; thread-safe.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

namespace brittle::physics {

struct Spin {
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0}; // of the principal axes in the world
    glm::dvec3 velocity{0.0};                   // rad/s, world axes
};

// Advances a torque-free body by `seconds` with the implicit midpoint rule in the body's axes and the Cayley map for
// the orientation R. Angular momentum L = R I R^T w and energy w . L / 2 are conserved to rounding at any step size. A
// substep rotates by at most max_turn_per_substep; faster spins take up to max_spin_substeps, and a spin beyond their
// product (960 rad/s at 1/120 s) is slowed down to it. Precondition: principal moments, in any unit, are positive and
// none exceeds the sum of the other two.
[[nodiscard]] Spin free_spin(const Spin& spin, const glm::dvec3& moments, double seconds);

// rad; the fixed-point iteration contracts by at least half of this.
inline constexpr double max_turn_per_substep = 0.5;
inline constexpr int max_spin_substeps = 16; // bounds the cost of one body

} // namespace brittle::physics
