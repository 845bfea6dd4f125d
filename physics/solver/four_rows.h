// Solves rows of four bodies side by side, whose other sides never move: the same operations as one at a time, bit for bit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "physics/solver/float4.h"
#include "physics/solver/row.h"

namespace brittle::physics {

using FourVectors = std::array<Float4, 3>; // x, y and z of four

// The motions of four bodies. Of fewer, the others are those of any mover and are not stored.
struct FourMotions {
    FourVectors linear, angular;
    Float4 light;

    FourMotions() = default;
    FourMotions(const std::array<uint32_t, 4>& movers, const Four& lights, const Motion* motions)
        : light(Float4::load(lights.data())) {
        const Motion &a = motions[movers[0]], &b = motions[movers[1]], &c = motions[movers[2]], &d = motions[movers[3]];
        for (size_t axis = 0; axis < 3; ++axis) {
            linear[axis] = Float4::of(a.linear[axis], b.linear[axis], c.linear[axis], d.linear[axis]);
            angular[axis] = Float4::of(a.angular[axis], b.angular[axis], c.angular[axis], d.angular[axis]);
        }
    }
    void store(const std::array<uint32_t, 4>& movers, uint32_t count, Motion* motions) const {
        for (size_t axis = 0; axis < 3; ++axis) {
            Four of_linear, of_angular;
            linear[axis].store(of_linear.data());
            angular[axis].store(of_angular.data());
            for (size_t lane = 0; lane < count; ++lane) {
                motions[movers[lane]].linear[axis] = of_linear[lane];
                motions[movers[lane]].angular[axis] = of_angular[lane];
            }
        }
    }

    // Lets impulses act along the rows.
    void act(const FourRows& rows, Float4 impulse) {
        const Float4 speed = impulse * light;
        for (size_t axis = 0; axis < 3; ++axis) {
            linear[axis] = linear[axis] + Float4::load(rows.normal[axis].data()) * speed;
            angular[axis] = angular[axis] + Float4::load(rows.turn[axis].data()) * impulse;
        }
    }
    // With impulses of their own, in place of the rows', that stay within bounds.
    void solve(const FourRows& rows, const Four& wanted, const Four& gain, Four& impulse, Float4 low, Float4 high) {
        FourVectors along;
        for (size_t axis = 0; axis < 3; ++axis)
            along[axis] = Float4::load(rows.normal[axis].data()) * linear[axis]
                          + Float4::load(rows.arm[axis].data()) * angular[axis];
        const Float4 apart = (along[0] + along[1]) + along[2];
        const Float4 before = Float4::load(impulse.data());
        const Float4 free = before + Float4::load(wanted.data()) - apart * Float4::load(gain.data());
        const Float4 after = min(max(free, low), high);
        after.store(impulse.data());
        act(rows, after - before);
    }
    // One contact of each, and its friction.
    void press(FourRows& rows) {
        solve(rows, rows.wanted, rows.gain, rows.impulse, Float4::all(0.0f),
              Float4::all(std::numeric_limits<float>::max()));
    }
    void rub(FourRows& rows, Float4 coefficient, const FourRows& contacts) {
        const Float4 most = coefficient * Float4::load(contacts.impulse.data());
        solve(rows, rows.wanted, rows.gain, rows.impulse, Float4::all(0.0f) - most, most);
    }
};

} // namespace brittle::physics
