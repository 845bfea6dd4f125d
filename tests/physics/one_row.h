// The parts of a substep for single rows (physics/solver/row.h), for bodies in contact with static ones: the oracle for
// rows that are solved side by side.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/solver/row.h"
#include "tests/physics/convex_pieces.h"

namespace brittle::test {

// A contact and its friction.
struct Touch {
    physics::Row row{};
    physics::FrictionRows friction{};
    float coefficient = 0.0f;
    bool limited = false; // whether a substep started from less than the impulse before
};

// A body, its contacts in the order of solution, its velocity and its displacement in the step.
struct Touching {
    physics::SolverBody body;
    std::vector<Touch> touches;
    physics::VelocityChange change{};
    physics::Displacement moved{};
    int blows = 0, limits = 0; // substeps in which contacts shared a blow, and in which energy was limited
};

// J dv, or J times a displacement
inline float apart(const float* along, const float* angular, const physics::VelocityChange& change) {
    float speed[3];
    for (int axis = 0; axis < 3; ++axis)
        speed[axis] = along[axis] * change.linear[axis] + angular[axis] * change.angular[axis];
    return (speed[0] + speed[1]) + speed[2];
}

// dv += M^-1 J^T impulse
inline void push(const float* along, const float* turn, float inverse_mass, float impulse,
                 physics::VelocityChange& change) {
    for (int axis = 0; axis < 3; ++axis) {
        change.linear[axis] += along[axis] * (impulse * inverse_mass);
        change.angular[axis] += turn[axis] * impulse;
    }
}
inline void push(const physics::Row& row, float impulse, physics::VelocityChange& change) {
    push(row.normal, row.inverse_inertia_angular_a, row.inverse_mass_a, impulse, change);
}
inline void push(const physics::FrictionRows& rows, const float* impulse, physics::VelocityChange& change) {
    for (int k = 0; k < 2; ++k)
        push(rows.along[k].tangent, rows.along[k].inverse_inertia_angular_a, rows.inverse_mass_a, impulse[k], change);
}

inline void fall(Touching& one, const physics::Substeps& substeps) {
    const glm::vec3 fall = substeps.gravity * substeps.seconds;
    for (int axis = 0; axis < 3 && one.body.inverse_mass > 0.0f; ++axis) one.change.linear[axis] += fall[axis];
}

inline void start(Touching& one, const physics::Substeps& substeps) {
    for (Touch& touch : one.touches) {
        physics::Row& row = touch.row;
        const float gap = row.gap + apart(row.normal, row.angular_a, one.moved);
        row.bias = row.rest;
        if (gap > 0.0f) row.bias -= gap / substeps.seconds * row.effective_mass;
        const float deep = -gap - row.slop;
        if (deep > 0.0f) push(row, deep * substeps.static_push_part * row.effective_mass, one.moved);
    }
}

inline void warm(Touching& one) {
    for (const Touch& touch : one.touches) {
        push(touch.row, touch.row.impulse, one.change);
        push(touch.friction, touch.friction.impulse, one.change);
    }
}

// Contacts that miss their target by more than a blow's speed share the blow. Returns whether there is a blow.
inline bool spread(Touching& one) {
    const auto missing = [&](const physics::Row& row) {
        return row.bias - apart(row.normal, row.angular_a, one.change) * row.effective_mass;
    };
    const auto slope = [&] {
        float sum = 0.0f;
        for (const Touch& touch : one.touches)
            if (touch.row.residual > 0.0f) sum += touch.row.residual * missing(touch.row) / touch.row.effective_mass;
        return sum;
    };
    for (Touch& touch : one.touches) {
        physics::Row& row = touch.row;
        const float impulse = missing(row);
        row.residual = impulse > physics::blow_speed * row.effective_mass ? impulse * row.share : 0.0f;
    }
    const float before = slope();
    for (const Touch& touch : one.touches) push(touch.row, touch.row.residual, one.change);
    const float after = slope(), factor = before > after ? before / (before - after) : 1.0f;
    for (Touch& touch : one.touches) {
        touch.row.impulse += touch.row.residual * factor;
        push(touch.row, touch.row.residual * (factor - 1.0f), one.change);
    }
    return before > 0.0f;
}

inline void solve_contacts(Touching& one) {
    for (Touch& touch : one.touches) {
        physics::Row& row = touch.row;
        const float before = row.impulse, speed = apart(row.normal, row.angular_a, one.change);
        row.impulse = std::max(before + row.bias - speed * row.effective_mass, 0.0f);
        push(row, row.impulse - before, one.change);
    }
}

inline void solve_friction(Touching& one) {
    for (Touch& touch : one.touches) {
        physics::FrictionRows& rows = touch.friction;
        float slow[2], stick[2], slide[2], added[2];
        for (int k = 0; k < 2; ++k)
            slow[k] = rows.along[k].rest - apart(rows.along[k].tangent, rows.along[k].angular_a, one.change);
        stick[0] = rows.impulse[0] + (rows.mass_11 * slow[0] + rows.mass_12 * slow[1]);
        stick[1] = rows.impulse[1] + (rows.mass_12 * slow[0] + rows.mass_22 * slow[1]);
        for (int k = 0; k < 2; ++k) slide[k] = rows.impulse[k] + rows.sliding_mass * slow[k];
        const float bound = touch.coefficient * touch.row.impulse;
        const bool sticks = stick[0] * stick[0] + stick[1] * stick[1] <= bound * bound;
        const float length = std::sqrt(slide[0] * slide[0] + slide[1] * slide[1]);
        const float part = length > bound ? bound / length : 1.0f;
        for (int k = 0; k < 2; ++k) {
            const float after = sticks ? stick[k] : slide[k] * part;
            added[k] = after - rows.impulse[k];
            rows.impulse[k] = after;
        }
        push(rows, added, one.change);
    }
}

inline void sweep(Touching& one, int times) {
    for (int i = 0; i < times; ++i) {
        solve_contacts(one);
        solve_friction(one);
    }
}

// Keeps the share of the impulses since `free` that adds no more kinetic energy than a fall from rest in a substep.
inline void limit_energy(Touching& one, const physics::VelocityChange& free, const physics::Substeps& substeps) {
    const auto dot = [](const float* a, const float* b) { return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]; };
    float added[3], turned[3], speed[3], spin[3], momentum[3];
    for (int axis = 0; axis < 3; ++axis) {
        added[axis] = one.change.linear[axis] - free.linear[axis];
        turned[axis] = one.change.angular[axis] - free.angular[axis];
        speed[axis] = one.body.linear[axis] + free.linear[axis];
        spin[axis] = one.body.angular[axis] + free.angular[axis];
    }
    for (int axis = 0; axis < 3; ++axis) momentum[axis] = dot(&one.body.inertia[axis].x, turned);
    const float first = one.body.mass * dot(speed, added) + dot(spin, momentum);
    const float square = 0.5f * (one.body.mass * dot(added, added) + dot(turned, momentum));
    const glm::vec3 fall = substeps.gravity * substeps.seconds;
    const float allowed = one.body.mass * (0.5f * glm::dot(fall, fall));
    if (!(first + square > allowed)) return;
    const float root = std::sqrt(std::max(first * first + 4.0f * square * allowed, 0.0f));
    const float share = first > 0.0f ? (allowed + allowed) / (root + first) : (root - first) / (square + square);
    for (int axis = 0; axis < 3; ++axis) {
        one.change.linear[axis] = free.linear[axis] + share * (one.change.linear[axis] - free.linear[axis]);
        one.change.angular[axis] = free.angular[axis] + share * (one.change.angular[axis] - free.angular[axis]);
    }
    for (Touch& touch : one.touches) {
        touch.row.impulse *= share;
        for (float& impulse : touch.friction.impulse) impulse *= share;
    }
    ++one.limits;
}

inline void move(Touching& one, float seconds) {
    for (int axis = 0; axis < 3; ++axis) {
        one.moved.linear[axis] += (one.body.linear[axis] + one.change.linear[axis]) * seconds;
        one.moved.angular[axis] += (one.body.angular[axis] + one.change.angular[axis]) * seconds;
    }
}

inline void start_second(Touching& one) {
    for (Touch& touch : one.touches)
        if (touch.row.impulse > 0.0f) touch.row.bias = touch.row.rest;
}

// Returns whether a contact bounces.
inline bool start_bounce(Touching& one) {
    bool any = false;
    for (Touch& touch : one.touches) {
        if (!(touch.row.bounce > 0.0f) || !(touch.row.total + touch.row.impulse > 0.0f)) continue;
        touch.row.bias = touch.row.rest + touch.row.bounce;
        any = true;
    }
    return any;
}

inline void finish(Touching& one) {
    for (Touch& touch : one.touches) {
        physics::Row& row = touch.row;
        row.total += row.impulse;
        for (int k = 0; k < 2; ++k) touch.friction.total[k] += touch.friction.impulse[k];
        const float most = physics::start_growth * row.start + physics::start_speed * row.effective_mass;
        if (row.impulse > most) {
            const float kept = most / row.impulse;
            row.impulse *= kept;
            for (float& friction : touch.friction.impulse) friction *= kept;
            touch.limited = true;
        }
        row.start = row.impulse;
    }
}

// Whether a contact pressed in the step, or its overlap was corrected.
inline bool acted(const Touching& one) {
    return std::ranges::any_of(one.touches, [](const Touch& touch) {
        return touch.row.total > 0.0f || touch.row.gap + touch.row.slop < 0.0f;
    });
}

// All substeps for bodies that are solved together: all have the sweeps of the bounce if one bounces. Returns whether
// one does.
inline bool solve(std::span<Touching* const> together, const physics::Substeps& substeps) {
    bool any = false;
    for (int substep = 0; substep < substeps.count; ++substep) {
        for (Touching* const one : together) {
            fall(*one, substeps);
            start(*one, substeps);
            const physics::VelocityChange free = one->change;
            warm(*one);
            one->blows += spread(*one) ? 1 : 0;
            sweep(*one, substeps.first);
            limit_energy(*one, free, substeps);
            move(*one, substeps.seconds);
            start_second(*one);
            spread(*one);
            const bool last = substep + 1 == substeps.count;
            sweep(*one, last ? substeps.last : substeps.second);
            if (last) any = start_bounce(*one) || any;
        }
        for (Touching* const one : together) {
            if (any) {
                spread(*one);
                sweep(*one, substeps.bounce);
            }
            finish(*one);
        }
    }
    return any;
}

// All substeps for bodies of which sixteen are solved together, those with the most contacts first.
inline bool solve_by_sixteen(std::vector<Touching*> all, const physics::Substeps& substeps) {
    std::ranges::stable_sort(
        all, [](const Touching* a, const Touching* b) { return a->touches.size() > b->touches.size(); });
    bool any = false;
    for (size_t i = 0; i < all.size(); i += 16)
        any = solve(std::span<Touching* const>(all).subspan(i, std::min<size_t>(16, all.size() - i)), substeps) || any;
    return any;
}

} // namespace brittle::test
