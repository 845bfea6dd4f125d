// Four contacts of debris in lanes, and the iterations that DebrisSolver makes over them.
//
// A lane holds one contact point between bodies a and b with unit normal n from b to a and lever arms r_a, r_b. With
// the relative velocity u = v_a + w_a x r_a - v_b - w_b x r_b, one iteration changes the impulses one after the other:
//     normal    lambda' = max(lambda - m_n (n . u - v_target), 0)
//     friction  f' = f - m_t u_t, shortened to |f'| <= mu lambda'
//     rolling   tau' = tau - m_r (w_a - w_b), shortened to |tau'| <= arm lambda'
// m_n is the inverse of the response to an impulse along n, m_t of the largest response to one across it, and m_r of a
// bound of that to a torque. Changing normal and friction at once would overshoot where one response dominates, as in
// thin crumbs.
//
// Bodies keep the changes of their velocity and angular momentum since the start of the step, which loses fewer digits
// than the velocities; the change of angular velocity is I^-1 L with the inertia of the start of the step.
// Pure functions on the arrays of DebrisBodies; four lanes of one group have different bodies.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "physics/solver/four_rows.h"
#include "physics/solver/row.h"

namespace brittle::physics {

// By body. A static or resting body has inverse mass and inverse inertia zero.
struct DebrisBodies {
    struct Motion {
        float linear[4];   // change of velocity, and the inverse mass
        float momentum[4]; // change of angular momentum
    };
    struct InverseInertia {
        float diagonal[4], off[4]; // xx, yy, zz; xy, xz, yz
    };
    std::vector<Motion> motions;
    std::vector<InverseInertia> inverse_inertias;
    std::vector<Displacement> moved; // since the start of the step
};

struct DebrisRows {
    std::array<uint32_t, 4> a{}, b{};
    std::array<Four, 3> normal{}, arm_a{}, arm_b{};
    std::array<Four, 3> apart{}, turning{};                      // u and w_a - w_b at the start of the step
    std::array<Four, 3> friction{}, friction_total{}, rolling{}; // impulses on a
    Four gap{}, slop{}, push{}; // push: part of an overlap that a substep corrects, in the displacement
    Four normal_mass{}, friction_mass{}, rolling_mass{};
    Four coefficient{}, rolling_arm{};
    Four impulse{}, total{}, start{}; // as in Row
    Four closing{}, bounce{};         // v_target of an open contact, and of the bounce
    Four pushed{};                    // above 0: an overlap was corrected in the step
};

// Functions of one group; `two_sided` is false if all b are static.
template<bool two_sided>
void start_substep(DebrisRows& rows, DebrisBodies& bodies); // applies the impulses
template<bool two_sided>
void solve_first(DebrisRows& rows, DebrisBodies& bodies, float substep_seconds, float longest_push); // m
template<bool two_sided>
void solve_second(DebrisRows& rows, DebrisBodies& bodies);
template<bool two_sided>
void solve_bounce(DebrisRows& rows,
                  DebrisBodies& bodies); // in place of the second solution, where bodies leave the step
// Multiplies the impulses by a share for each lane.
void scale(DebrisRows& rows, const Four& share);
// Adds the impulses of a substep to the totals and limits those from which the next one starts.
void finish_substep(DebrisRows& rows);

} // namespace brittle::physics
