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
// v is the velocity before the step; dv is the change since, by gravity and the sweeps. The terms of b vanish where b is
// static.
//
// A step is divided into substeps of h seconds. Rows are built once a step. Each substep adds gravity to the
// velocities, starts lambda from its last value (start_growth below), and solves the rows twice. Bodies move with the
// velocities of the first solution, and leave the substep with those of the second, which goes on from the first with
// other targets:
//     contact           lambda >= 0
//       first           v_target = -max(gap, 0) / h: a gap closes by the end of the substep at most
//       second          v_target = 0 if lambda > 0, and else that of the first
//       bounce          once, after the last substep: v_target = max(0, -e J v_0) for contacts that pressed in the
//                       step, 0 for impacts below min_bounce_speed; e is the restitution, v_0 the velocity before
//                       the step
//     friction          two rows along orthogonal tangents, solved together: v_target = 0 and
//                       |(lambda_1, lambda_2)| <= mu lambda_contact (Coulomb's cone; mu is the friction coefficient)
// The gap of a substep is that of the step plus J times the displacement since. A body that bounces reaches the surface
// first. Overlap is corrected in the displacement, by push_part max(overlap - slop, 0) a substep, and leaves no
// velocity. An overlap up to the slop stays, because its correction makes stacks sway. Corrections for static bodies use
// static_push_part.
//
// M. Macklin et al., "Small steps in physics simulation", 2019 (substeps instead of iterations); E. Catto, "Solver2D",
// 2024 (the second solution).
// E. Catto, "Iterative Dynamics with Temporal Coherence", 2005.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <glm/vec3.hpp>

namespace brittle::physics {

// The row of a contact. Vectors are packed; four floats can be read at the start of each.
struct Row {
    float normal[3];                                                  // n, from b to a
    float angular_a[3], angular_b[3];                                 // r_a x n and n x r_b
    float inverse_inertia_angular_a[3], inverse_inertia_angular_b[3]; // I^-1 times these: rad/s per N s
    float rest;                                                       // N s; -m_eff J v of the start of the step
    float bias;                                                       // N s; rest plus m_eff v_target
    float effective_mass;                                             // kg
    float gap, slop;                                                  // m; a negative gap is an overlap
    float bounce;                                                     // N s; m_eff v_target of the bounce; 0: none
    float impulse, total;                 // N s; lambda of the substep, and the sum over the substeps before
    float start;                          // N s; lambda at the start of the substep
    float share;                          // 1 / number of contact points of the body that has more
    float residual;                       // N s, of spread(): the impulse that is added, up to a factor
    float inverse_mass_a, inverse_mass_b; // 1/kg
    uint32_t a, b;                        // indices of solver bodies; b is unset if it is static
};

// A packed vector of a row.
inline glm::vec3 vec3_of(const float* packed) {
    return {packed[0], packed[1], packed[2]};
}

// The friction of a contact: two rows along tangents t_1 and t_2. Their effective mass is the inverse of the symmetric
// 2 x 2 matrix K with K_ij = J_i M^-1 J_j^T. One iteration with w = -(J v + J dv), the sliding velocity reversed:
//     lambda' = lambda + K^-1 w                     if that is inside the cone, and otherwise
//     lambda' = lambda + w / trace K, scaled back to the cone.
// The second keeps friction opposite to the sliding velocity, as Coulomb's law has it; K^-1 w has another direction.
struct FrictionRows {
    struct Along {
        float tangent[3];
        float angular_a[3], angular_b[3];
        float inverse_inertia_angular_a[3], inverse_inertia_angular_b[3];
        float rest; // m/s; -J v of the start of the step
    };
    Along along[2];
    float mass_11, mass_12, mass_22; // kg, K^-1
    float sliding_mass;              // kg; 1 / trace K
    float impulse[2], total[2];      // N s, as in Row
    float inverse_mass_a, inverse_mass_b;
    uint32_t a, b; // as in Row
};

// Four rows in lanes; the b of each is static.
using Four = std::array<float, 4>;
struct FourRows {
    std::array<Four, 3> normal, angular, inverse_inertia_angular;
    Four rest, bias, effective_mass, gap, slop, bounce, impulse, total, start, share, residual;
};
struct FourFrictions {
    struct Along {
        std::array<Four, 3> tangent, angular, inverse_inertia_angular;
        Four rest, impulse, total;
    };
    std::array<Along, 2> along;
    Four mass_11, mass_12, mass_22, sliding_mass;
};

// State of a body at the start of the sweeps.
struct SolverBody {
    glm::vec3 inverse_inertia[3]{};                      // rows, in world axes
    glm::vec3 centre{0.0f}, linear{0.0f}, angular{0.0f}; // v
    float inverse_mass = 0.0f;                           // 1/kg; 0 for a resting body, whose inverse inertia is 0 too
    glm::vec3 inertia[3]{};                              // kg m^2, as inverse_inertia
    float mass = 0.0f;                                   // kg; 0 for a resting body
    float share = 1.0f;                                  // 1 / number of its contact points
};

// dv: the change of a body's velocity since the start of the step, by gravity and the sweeps. The last of four
// components is 0.
struct VelocityChange {
    float linear[4], angular[4];
};
// Displacement since the start of the step: a translation, m, and a small rotation, rad.
using Displacement = VelocityChange;

// The two solutions of a substep.
enum class Solution : uint8_t { first, second };

// The substeps of a step, and the numbers of sweeps in them.
struct Substeps {
    int count = 1;
    int first = 0, second = 0; // sweeps
    int last = 0, bounce = 0;  // sweeps of the last substep's second solution, and of the bounce
    float seconds = 0.0f;      // of a substep
    glm::vec3 gravity{0.0f};
    // Parts of an overlap that a substep corrects: between moving bodies, and with a static one.
    float push_part = 0.0f, static_push_part = 0.0f;

    [[nodiscard]] glm::vec3 fall() const { return gravity * seconds; }
};

// A substep starts from the last impulse of a contact, but from no more than start_growth times the impulse from which
// the substep before it started, plus the impulse of start_speed, m/s. The impulse of a blow is a hundred times the one
// that follows it, in all contacts that pass it on, and the part that the sweeps do not take back would add energy.
//
// Contacts that miss their target by more than blow_speed, m/s, before the sweeps of a solution or of the bounce share
// the blow: each gets its residual, share * (bias - m_eff J dv), times the factor that leaves the least
//     1/2 v . M v - sum lambda v_target,
// one for each component of bodies. The points of a face that lands flat then take the blow evenly; sweeps alone would
// give the first points most of it, and turn the body. (Steepest descent with exact line search; shares: mass splitting,
// R. Tonge, F. Benevolenski and A. Voroshilov, 2012.)
inline constexpr float start_growth = 1.5f, start_speed = 0.01f, blow_speed = 0.05f;

// The kinetic energy that impulses add to a component of bodies, J: with a share s of them, linear s + square s^2.
struct AddedEnergy {
    double linear = 0.0, square = 0.0;
    double allowed = 0.0;
    // The greatest share, at most 1, that adds no more than is allowed.
    [[nodiscard]] float share() const {
        if (!(linear + square > allowed)) return 1.0f;
        const double root = std::sqrt(linear * linear + 4.0 * square * allowed);
        return static_cast<float>(linear > 0.0 ? 2.0 * allowed / (root + linear) : (root - linear) / (2.0 * square));
    }
};

// How fast residuals lower the sum above, J: at its start, and with the factor one.
struct Descent {
    float start = 0.0f, end = 0.0f;
    // The factor that leaves the least.
    [[nodiscard]] float factor() const { return start > end ? start / (start - end) : 1.0f; }
};

} // namespace brittle::physics
