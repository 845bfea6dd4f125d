// Constraint rows: what the solver's sweeps run over, and what rows are made of.
//
// A row constrains the relative velocity of two bodies along one direction n at a point. With the lever arms r from the
// centres of mass, its Jacobian is
//     J = [ n,  r_a x n,  -n,  n x r_b ]      so that  J v  is the speed at which the sides part;
// its effective mass, 1/(kg) inverted, is
//     m_eff = 1 / (J M^-1 J^T) = 1 / (1/m_a + 1/m_b + (r_a x n) . I_a^-1 (r_a x n) + (n x r_b) . I_b^-1 (n x r_b));
// and one iteration of projected Gauss-Seidel changes its accumulated impulse lambda to
//     lambda' = clamp(lambda + bias - m_eff J dv),   bias = m_eff (v_target - J v),
// v being the velocity before the sweeps and dv what the sweeps have changed so far.
//
// E. Catto, "Iterative Dynamics with Temporal Coherence", 2005.
#pragma once

#include <array>
#include <cstdint>

#include <glm/vec3.hpp>

namespace brittle::physics {

// The square of the speed, m^2/s^2, below which two sides do not slide on each other.
inline constexpr float min_sliding_square = 1e-9f;

// Of a contact or of its friction. Vectors lie without gaps; four floats can be read at each.
struct Row {
    float normal[3];                                                  // n, from b to a
    float angular_a[3], angular_b[3];                                 // r_a x n and n x r_b
    float inverse_inertia_angular_a[3], inverse_inertia_angular_b[3]; // I^-1 times these: what a unit of impulse turns
    float bias;                                                       // N s
    float effective_mass;                                             // kg
    float impulse;                                                    // accumulated, N s
    float inverse_mass_a, inverse_mass_b;                             // 1/kg
    uint32_t a, b; // solver bodies; of a row with one body that never moves, b is not to be read
};

// Four rows side by side whose b never moves.
using Four = std::array<float, 4>;
struct FourRows {
    std::array<Four, 3> normal, angular, inverse_inertia_angular;
    Four bias, effective_mass, impulse;
};

// A body as it enters the solution.
struct SolverBody {
    glm::vec3 inverse_inertia[3]{};                      // rows, in world axes
    glm::vec3 centre{0.0f}, linear{0.0f}, angular{0.0f}; // the step's gravity is in the velocity
    float inverse_mass = 0.0f;                           // 0 of a resting body, as its inverse inertia is
};

// What the sweeps have changed of a body's velocity so far. The last of four is 0.
struct VelocityChange {
    float linear[4], angular[4];
};

} // namespace brittle::physics
