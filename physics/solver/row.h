// Constraint rows: the data that the solver's sweeps iterate over, and their equations.
//
// A row constrains the relative velocity of bodies a and b along one unit direction n (from b to a) at one point. With
// the lever arms r_a and r_b from the centres of mass to that point, its Jacobian is
//     J = [ n,  r_a x n,  -n,  n x r_b ],   so that J v is the speed at which the sides part;
// its effective mass, in kg, is
//     m_eff = 1 / (J M^-1 J^T) = 1 / (1/m_a + 1/m_b + (r_a x n) . I_a^-1 (r_a x n) + (n x r_b) . I_b^-1 (n x r_b));
// and one iteration of projected Gauss-Seidel changes its accumulated impulse lambda, in N s, and the velocities by
//     lambda' = clamp(lambda + bias - m_eff J dv, low, high),   dv += M^-1 J^T (lambda' - lambda),
//     bias = m_eff (v_target - J v).
// v is the velocity before the sweeps, with the step's gravity; dv is the change by the sweeps so far. The terms of b
// vanish where b is static.
//
// For a step of h seconds, the three kinds of rows are:
//     contact           v_target = bounce - max(distance, 0) / h,   lambda >= 0
//                       bounce = max(0, -e J v_0), 0 for impacts below min_bounce_speed;
//                       e is the restitution, v_0 the velocity before the step's gravity
//     friction          v_target = 0,   |lambda| <= mu lambda_contact (Coulomb; mu is the friction coefficient)
//     split impulse     bias = m_eff correction_part max(-distance, 0) / h,   lambda >= 0, with a dv of its own that
//                       corrects positions and no velocities
//
// E. Catto, "Iterative Dynamics with Temporal Coherence", 2005.
#pragma once

#include <array>
#include <cstdint>

#include <glm/vec3.hpp>

namespace brittle::physics {

// Square of the speed, m^2/s^2, below which two sides count as not sliding on each other.
inline constexpr float min_sliding_square = 1e-9f;

// The row of a contact or of its friction. Vectors are packed; four floats can be read at the start of each.
struct Row {
    float normal[3];                                                  // n, from b to a
    float angular_a[3], angular_b[3];                                 // r_a x n and n x r_b
    float inverse_inertia_angular_a[3], inverse_inertia_angular_b[3]; // I^-1 times these: rad/s per N s
    float bias;                                                       // N s
    float effective_mass;                                             // kg
    float impulse;                                                    // lambda, N s
    float inverse_mass_a, inverse_mass_b;                             // 1/kg
    uint32_t a, b; // indices of solver bodies; b is unset if it is static
};

// Four rows in lanes; the b of each is static.
using Four = std::array<float, 4>;
struct FourRows {
    std::array<Four, 3> normal, angular, inverse_inertia_angular;
    Four bias, effective_mass, impulse;
};

// State of a body at the start of the sweeps.
struct SolverBody {
    glm::vec3 inverse_inertia[3]{};                      // rows, in world axes
    glm::vec3 centre{0.0f}, linear{0.0f}, angular{0.0f}; // v: includes the step's gravity
    float inverse_mass = 0.0f;                           // 1/kg; 0 for a resting body, whose inverse inertia is 0 too
};

// dv: the change of a body's velocity by the sweeps so far. The last of four components is 0.
struct VelocityChange {
    float linear[4], angular[4];
};

} // namespace brittle::physics
