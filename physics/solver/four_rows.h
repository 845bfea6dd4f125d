// Iterations of four rows in lanes: rows of four bodies against static sides (row.h). The operations per row and their
// order are those of RowSolver, so results are equal bit for bit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "physics/solver/float4.h"
#include "physics/solver/row.h"

namespace brittle::physics {

using FourVectors = std::array<Float4, 3>; // x, y and z of four vectors

// The velocity changes dv of four bodies. With fewer bodies, the surplus lanes hold those of any body and are not
// stored.
struct FourChanges {
    FourVectors linear, angular;
    Float4 inverse_mass;

    FourChanges() = default;
    FourChanges(const std::array<uint32_t, 4>& bodies, const Four& inverse_masses, const VelocityChange* changes)
        : inverse_mass(Float4::load(inverse_masses.data())) {
        const VelocityChange &a = changes[bodies[0]], &b = changes[bodies[1]];
        const VelocityChange &c = changes[bodies[2]], &d = changes[bodies[3]];
        for (size_t axis = 0; axis < 3; ++axis) {
            linear[axis] = Float4::of(a.linear[axis], b.linear[axis], c.linear[axis], d.linear[axis]);
            angular[axis] = Float4::of(a.angular[axis], b.angular[axis], c.angular[axis], d.angular[axis]);
        }
    }
    void store(const std::array<uint32_t, 4>& bodies, uint32_t count, VelocityChange* changes) const {
        for (size_t axis = 0; axis < 3; ++axis) {
            Four of_linear, of_angular;
            linear[axis].store(of_linear.data());
            angular[axis].store(of_angular.data());
            for (size_t lane = 0; lane < count; ++lane) {
                changes[bodies[lane]].linear[axis] = of_linear[lane];
                changes[bodies[lane]].angular[axis] = of_angular[lane];
            }
        }
    }

    // dv += M^-1 J^T impulse, for side a
    void apply(const FourRows& rows, Float4 impulse) {
        const Float4 speed = impulse * inverse_mass;
        for (size_t axis = 0; axis < 3; ++axis) {
            linear[axis] = linear[axis] + Float4::load(rows.normal[axis].data()) * speed;
            angular[axis] = angular[axis] + Float4::load(rows.inverse_inertia_angular[axis].data()) * impulse;
        }
    }
    // One iteration (row.h) with the given bias, m_eff and lambda instead of the rows' own; lambda is clamped to
    // [low, high].
    void solve(const FourRows& rows, const Four& bias, const Four& effective_mass, Four& impulse, Float4 low,
               Float4 high) {
        FourVectors speed;
        for (size_t axis = 0; axis < 3; ++axis)
            speed[axis] = Float4::load(rows.normal[axis].data()) * linear[axis]
                          + Float4::load(rows.angular[axis].data()) * angular[axis];
        const Float4 apart = (speed[0] + speed[1]) + speed[2];
        const Float4 before = Float4::load(impulse.data());
        const Float4 free = before + Float4::load(bias.data()) - apart * Float4::load(effective_mass.data());
        const Float4 after = min(max(free, low), high);
        after.store(impulse.data());
        apply(rows, after - before);
    }
    // Contact rows: lambda >= 0.
    void solve_contacts(FourRows& rows) {
        solve(rows, rows.bias, rows.effective_mass, rows.impulse, Float4::all(0.0f),
              Float4::all(std::numeric_limits<float>::max()));
    }
    // Friction rows: |lambda| <= mu lambda_contact.
    void solve_friction(FourRows& rows, Float4 coefficient, const FourRows& contacts) {
        const Float4 bound = coefficient * Float4::load(contacts.impulse.data());
        solve(rows, rows.bias, rows.effective_mass, rows.impulse, Float4::all(0.0f) - bound, bound);
    }
};

} // namespace brittle::physics
