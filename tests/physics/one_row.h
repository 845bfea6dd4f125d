// One row, as Gauss and Seidel have it: the oracle for those that are solved side by side. Of a body beside one that never moves.
#pragma once

#include <algorithm>

#include "physics/solver/row.h"

namespace brittle::test {

inline void push(const physics::Row& row, float impulse, physics::Motion& motion) {
    for (int axis = 0; axis < 3; ++axis) {
        motion.linear[axis] += row.normal[axis] * (impulse * row.light_a);
        motion.angular[axis] += row.turn_a[axis] * impulse;
    }
}

inline void solve(physics::Row& row, float low, float high, physics::Motion& motion) {
    float along[3];
    for (int axis = 0; axis < 3; ++axis)
        along[axis] = row.normal[axis] * motion.linear[axis] + row.arm_a[axis] * motion.angular[axis];
    const float apart = (along[0] + along[1]) + along[2], before = row.impulse;
    row.impulse = std::clamp(before + row.wanted - apart * row.gain, low, high);
    push(row, row.impulse - before, motion);
}

} // namespace brittle::test
