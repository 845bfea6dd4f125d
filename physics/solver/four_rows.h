// Iterations of four rows in lanes: rows of four bodies against static sides (row.h). Each lane solves the equations of
// RowSolver in the same order; results may differ by rounding.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <glm/geometric.hpp>

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
    // One iteration of contact rows (row.h): lambda >= 0.
    void solve_contacts(FourRows& rows) {
        const Float4 before = Float4::load(rows.impulse.data());
        const Float4 free =
            before + Float4::load(rows.bias.data()) - apart(rows) * Float4::load(rows.effective_mass.data());
        const Float4 after = max(free, Float4::all(0.0f));
        after.store(rows.impulse.data());
        apply(rows, after - before);
    }
    // Starts a substep: sets the targets of the first solution, and corrects overlap in the displacement since the start
    // of the step, `moved`.
    static void start(FourRows& rows, FourChanges& moved, const Substeps& substeps) {
        const Float4 none = Float4::all(0.0f), mass = Float4::load(rows.effective_mass.data());
        const Float4 gap = Float4::load(rows.gap.data()) + moved.apart(rows);
        const Float4 bias = Float4::load(rows.rest.data()) - max(gap, none) / Float4::all(substeps.seconds) * mass;
        bias.store(rows.bias.data());
        const Float4 push = max(none - gap - Float4::load(rows.slop.data()), none);
        moved.apply(rows, push * Float4::all(substeps.static_push_part) * mass);
    }
    // Warm starting.
    void apply(const FourRows& rows, const FourFrictions& frictions) {
        apply(rows, Float4::load(rows.impulse.data()));
        for (const FourFrictions::Along& along : frictions.along) apply(along, Float4::load(along.impulse.data()));
    }
    // Spreading of blows (row.h). Sets the residuals; returns whether there is one.
    bool find_residuals(FourRows& rows) const {
        const Float4 none = Float4::all(0.0f), mass = Float4::load(rows.effective_mass.data());
        const Float4 missing = Float4::load(rows.bias.data()) - apart(rows) * mass,
                     least = Float4::all(blow_speed) * mass;
        where_less(least, missing, missing * Float4::load(rows.share.data()), none).store(rows.residual.data());
        return less(least, missing) != 0;
    }
    // The part of the rows in the descent.
    [[nodiscard]] Float4 descent(const FourRows& rows) const {
        const Float4 none = Float4::all(0.0f), mass = Float4::load(rows.effective_mass.data());
        const Float4 residual = Float4::load(rows.residual.data());
        const Float4 missing = Float4::load(rows.bias.data()) - apart(rows) * mass;
        return where_less(none, residual, residual * missing / mass, none);
    }
    // Adds the residuals to the velocities.
    void add_residuals(const FourRows& rows) { apply(rows, Float4::load(rows.residual.data())); }
    // Multiplies what was added by a factor, and adds it to the impulses.
    void spread(FourRows& rows, Float4 factor) {
        const Float4 residual = Float4::load(rows.residual.data());
        (Float4::load(rows.impulse.data()) + residual * factor).store(rows.impulse.data());
        apply(rows, residual * (factor - Float4::all(1.0f)));
    }
    // Multiplies impulses by a share.
    static void scale(FourRows& rows, FourFrictions& frictions, Float4 share) {
        (Float4::load(rows.impulse.data()) * share).store(rows.impulse.data());
        for (FourFrictions::Along& along : frictions.along)
            (Float4::load(along.impulse.data()) * share).store(along.impulse.data());
    }
    // Sets the targets of the second solution.
    static void start_second(FourRows& rows) {
        const Float4 none = Float4::all(0.0f), rest = Float4::load(rows.rest.data());
        where_less(none, Float4::load(rows.impulse.data()), rest, Float4::load(rows.bias.data()))
            .store(rows.bias.data());
    }
    // Sets the targets of the bounce; returns whether there is one.
    static bool start_bounce(FourRows& rows) {
        const Float4 none = Float4::all(0.0f), bounce = Float4::load(rows.bounce.data());
        const Float4 loaded = Float4::load(rows.impulse.data()) + Float4::load(rows.total.data());
        const Float4 bias = Float4::load(rows.bias.data());
        where_less(none, loaded, where_less(none, bounce, Float4::load(rows.rest.data()) + bounce, bias), bias)
            .store(rows.bias.data());
        return (less(none, bounce) & less(none, loaded)) != 0;
    }
    // Ends a substep: adds its impulses to those of the step, and limits those from which the next one starts.
    static void finish(FourRows& rows, FourFrictions& frictions) {
        const Float4 impulse = Float4::load(rows.impulse.data()), one = Float4::all(1.0f);
        const Float4 limit = Float4::all(start_growth) * Float4::load(rows.start.data())
                             + Float4::all(start_speed) * Float4::load(rows.effective_mass.data());
        const Float4 kept = where_less(limit, impulse, limit / impulse, one);
        (Float4::load(rows.total.data()) + impulse).store(rows.total.data());
        (impulse * kept).store(rows.impulse.data());
        (impulse * kept).store(rows.start.data());
        for (FourFrictions::Along& along : frictions.along) {
            const Float4 friction = Float4::load(along.impulse.data());
            (Float4::load(along.total.data()) + friction).store(along.total.data());
            (friction * kept).store(along.impulse.data());
        }
    }
    // Bit i is set if the contact in lane i acted on its body in the step: it pressed, or its overlap was corrected.
    [[nodiscard]] static uint32_t acts(const FourRows& rows) {
        const Float4 none = Float4::all(0.0f);
        return less(none, Float4::load(rows.total.data()))
               | less(Float4::load(rows.gap.data()) + Float4::load(rows.slop.data()), none);
    }
    // J dv
    [[nodiscard]] Float4 apart(const FourRows& rows) const {
        FourVectors speed;
        for (size_t axis = 0; axis < 3; ++axis)
            speed[axis] = Float4::load(rows.normal[axis].data()) * linear[axis]
                          + Float4::load(rows.angular[axis].data()) * angular[axis];
        return (speed[0] + speed[1]) + speed[2];
    }
    // Gravity, for bodies that have no infinite mass.
    void fall(const glm::vec3& by) {
        const Float4 none = Float4::all(0.0f);
        for (size_t axis = 0; axis < 3; ++axis)
            linear[axis] = linear[axis] + where_less(none, inverse_mass, Float4::all(by[static_cast<int>(axis)]), none);
    }
    // Keeps a share of what was added to `free`, in lanes where it is less than 1.
    void keep(const FourChanges& free, Float4 share) {
        const Float4 one = Float4::all(1.0f);
        const auto kept = [&](Float4 before, Float4 now) {
            return where_less(share, one, before + share * (now - before), now);
        };
        for (size_t axis = 0; axis < 3; ++axis) {
            linear[axis] = kept(free.linear[axis], linear[axis]);
            angular[axis] = kept(free.angular[axis], angular[axis]);
        }
    }
    // Adds the displacement of a substep at the velocity v + dv.
    void move(const FourVectors& v_linear, const FourVectors& v_angular, const FourChanges& changes, Float4 seconds) {
        for (size_t axis = 0; axis < 3; ++axis) {
            linear[axis] = linear[axis] + (v_linear[axis] + changes.linear[axis]) * seconds;
            angular[axis] = angular[axis] + (v_angular[axis] + changes.angular[axis]) * seconds;
        }
    }
    // Friction: the length of (lambda_1, lambda_2) is at most mu lambda_contact.
    void solve_friction(FourFrictions& rows, Float4 coefficient, const FourRows& contacts) {
        const Float4 bound = coefficient * Float4::load(contacts.impulse.data());
        const auto apart = [&](const FourFrictions::Along& along) {
            FourVectors speed;
            for (size_t axis = 0; axis < 3; ++axis)
                speed[axis] = Float4::load(along.tangent[axis].data()) * linear[axis]
                              + Float4::load(along.angular[axis].data()) * angular[axis];
            return (speed[0] + speed[1]) + speed[2];
        };
        const Float4 slow_1 = Float4::load(rows.along[0].rest.data()) - apart(rows.along[0]);
        const Float4 slow_2 = Float4::load(rows.along[1].rest.data()) - apart(rows.along[1]);
        const Float4 mass_12 = Float4::load(rows.mass_12.data()), mass = Float4::load(rows.sliding_mass.data());
        const Float4 before_1 = Float4::load(rows.along[0].impulse.data());
        const Float4 before_2 = Float4::load(rows.along[1].impulse.data());
        const Float4 stick_1 = before_1 + (Float4::load(rows.mass_11.data()) * slow_1 + mass_12 * slow_2);
        const Float4 stick_2 = before_2 + (mass_12 * slow_1 + Float4::load(rows.mass_22.data()) * slow_2);
        const Float4 slide_1 = before_1 + mass * slow_1, slide_2 = before_2 + mass * slow_2;
        const Float4 length = sqrt(slide_1 * slide_1 + slide_2 * slide_2);
        const Float4 part = where_less(bound, length, bound / length, Float4::all(1.0f));
        const Float4 limit = bound * bound, square = stick_1 * stick_1 + stick_2 * stick_2;
        const Float4 after_1 = where_less(limit, square, slide_1 * part, stick_1);
        const Float4 after_2 = where_less(limit, square, slide_2 * part, stick_2);
        after_1.store(rows.along[0].impulse.data());
        after_2.store(rows.along[1].impulse.data());
        apply(rows.along[0], after_1 - before_1);
        apply(rows.along[1], after_2 - before_2);
    }
    void apply(const FourFrictions::Along& along, Float4 impulse) {
        const Float4 speed = impulse * inverse_mass;
        for (size_t axis = 0; axis < 3; ++axis) {
            linear[axis] = linear[axis] + Float4::load(along.tangent[axis].data()) * speed;
            angular[axis] = angular[axis] + Float4::load(along.inverse_inertia_angular[axis].data()) * impulse;
        }
    }
};

// The motion and mass of four bodies at the start of the step.
struct FourBodies {
    FourVectors linear, angular; // v
    std::array<FourVectors, 3> inertia;
    Float4 mass;

    FourBodies() = default;
    FourBodies(const std::array<uint32_t, 4>& bodies, const SolverBody* all) {
        const auto lanes = [&](const auto& value) {
            return Float4::of(value(all[bodies[0]]), value(all[bodies[1]]), value(all[bodies[2]]),
                              value(all[bodies[3]]));
        };
        for (size_t axis = 0; axis < 3; ++axis) {
            const auto i = static_cast<int>(axis);
            linear[axis] = lanes([i](const SolverBody& body) { return body.linear[i]; });
            angular[axis] = lanes([i](const SolverBody& body) { return body.angular[i]; });
            for (size_t row = 0; row < 3; ++row)
                inertia[row][axis] = lanes([&](const SolverBody& body) { return body.inertia[row][i]; });
        }
        mass = lanes([](const SolverBody& body) { return body.mass; });
    }
    // The share of the impulses between `free` and `now` that adds no more kinetic energy than falling from rest in a
    // substep: see RowSolver::limit_energy().
    [[nodiscard]] Float4 energy_share(const FourChanges& free, const FourChanges& now, const glm::vec3& fall) const {
        const auto dot = [](const FourVectors& a, const FourVectors& b) {
            return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
        };
        FourVectors added, turned, speed, spin;
        for (size_t axis = 0; axis < 3; ++axis) {
            added[axis] = now.linear[axis] - free.linear[axis];
            turned[axis] = now.angular[axis] - free.angular[axis];
            speed[axis] = linear[axis] + free.linear[axis];
            spin[axis] = angular[axis] + free.angular[axis];
        }
        const FourVectors momentum{dot(inertia[0], turned), dot(inertia[1], turned), dot(inertia[2], turned)};
        const Float4 zero = Float4::all(0.0f), half = Float4::all(0.5f);
        const Float4 first = mass * dot(speed, added) + dot(spin, momentum);
        const Float4 square = half * (mass * dot(added, added) + dot(turned, momentum));
        const Float4 allowed = mass * Float4::all(0.5f * glm::dot(fall, fall));
        const Float4 root = sqrt(max(first * first + Float4::all(4.0f) * square * allowed, zero));
        const Float4 share =
            where_less(zero, first, (allowed + allowed) / (root + first), (root - first) / (square + square));
        return where_less(allowed, first + square, share, Float4::all(1.0f));
    }
};

// Spreading of blows for four bodies in lanes, each a component of its own. visit_rows(f) calls f(rows, velocity changes,
// descents) for all rows, where the descents belong to their four bodies.
struct FourDescents {
    Float4 start = Float4::all(0.0f), end = Float4::all(0.0f);
    [[nodiscard]] Float4 factor() const {
        const Float4 one = Float4::all(1.0f);
        return where_less(end, start, start / (start - end), one);
    }
};
void spread_blows(const auto& visit_rows) {
    bool any = false;
    visit_rows([&](FourRows& rows, FourChanges& of, FourDescents&) { any = of.find_residuals(rows) || any; });
    if (!any) return;
    visit_rows([](FourRows& rows, FourChanges& of, FourDescents& sum) { sum.start = sum.start + of.descent(rows); });
    visit_rows([](FourRows& rows, FourChanges& of, FourDescents&) { of.add_residuals(rows); });
    visit_rows([](FourRows& rows, FourChanges& of, FourDescents& sum) { sum.end = sum.end + of.descent(rows); });
    visit_rows([](FourRows& rows, FourChanges& of, FourDescents& sum) { of.spread(rows, sum.factor()); });
}

} // namespace brittle::physics
