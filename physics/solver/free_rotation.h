// Rotation of a rigid body without torque: a step that conserves what physics does.
//
// Bullet integrates orientation with the velocity of one instant. Its gyroscopic term, one Newton iteration
// of an implicit Euler step, damps tumbling visibly (a splinter stops flipping) and turns the angular
// momentum; without the term the energy of a tumbling body grows without bound. The implicit midpoint rule
// costs as little and keeps both.
//
// Pure functions of plain values; radians, seconds; no state.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

namespace brittle::physics {

struct Spin {
    glm::dquat orientation{1.0, 0.0, 0.0, 0.0}; // of the principal axes in the world
    glm::dvec3 velocity{0.0};                   // angular, world axes
};

// Moves a torque-free body through seconds by the implicit midpoint rule in the body's axes with the Cayley
// map for the orientation: angular momentum R I R^T w and energy w.L/2 are both conserved to rounding, at any
// step size. A step turns by at most max_turn_per_substep; faster spins are split into up to
// max_spin_substeps, and what is faster still (beyond 960 rad/s at 1/120 s) is slowed down to that. Moments
// must be those of a body: positive, none above the sum of the other two.
[[nodiscard]] Spin free_spin(const Spin& spin, const glm::dvec3& moments, double seconds);

inline constexpr double max_turn_per_substep = 0.5; // rad; the fixed-point iteration contracts by half of it or better
inline constexpr int max_spin_substeps = 16;        // bounds the cost of one body

} // namespace brittle::physics
