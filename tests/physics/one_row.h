// One iteration of projected Gauss-Seidel on a single row (physics/solver/row.h), for a body in contact with a static
// one: the oracle for rows that are solved side by side.
#pragma once

#include <algorithm>

#include "physics/solver/row.h"

namespace brittle::test {

// dv += M^-1 J^T impulse
inline void apply(const physics::Row& row, float impulse, physics::VelocityChange& change) {
    for (int axis = 0; axis < 3; ++axis) {
        change.linear[axis] += row.normal[axis] * (impulse * row.inverse_mass_a);
        change.angular[axis] += row.inverse_inertia_angular_a[axis] * impulse;
    }
}

// Changes the accumulated impulse within [low, high], and the velocity with it.
inline void solve(physics::Row& row, float low, float high, physics::VelocityChange& change) {
    float speed[3];
    for (int axis = 0; axis < 3; ++axis)
        speed[axis] = row.normal[axis] * change.linear[axis] + row.angular_a[axis] * change.angular[axis];
    const float apart = (speed[0] + speed[1]) + speed[2], before = row.impulse;
    row.impulse = std::clamp(before + row.bias - apart * row.effective_mass, low, high);
    apply(row, row.impulse - before, change);
}

} // namespace brittle::test
