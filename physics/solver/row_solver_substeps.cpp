// The substeps of a bundle (row.h).
#include "physics/solver/row_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/solver/float4.h"

namespace brittle::physics {

void RowSolver::solve_contacts(std::span<Row> rows, VelocityChange* changes) {
    for (Row& row : rows) solve_row(row, changes);
}

// |(lambda_1, lambda_2)| <= mu lambda_contact.
void RowSolver::solve_friction(size_t begin, size_t end) {
    VelocityChange* const changes = changes_.data();
    for (size_t i = begin; i < end; ++i) {
        FrictionRows& rows = frictions_[i];
        const float most = coefficients_[i] * contacts_[i].impulse;
        if (most <= 0.0f && rows.impulse[0] == 0.0f && rows.impulse[1] == 0.0f) continue;
        const VelocityChange &a = changes[rows.a], &b = changes[rows.b];
        const Float4 linear = Float4::load(a.linear) - Float4::load(b.linear);
        const Float4 angular_a = Float4::load(a.angular), angular_b = Float4::load(b.angular);
        const auto apart = [&](const FrictionRows::Along& along) {
            return sum3(Float4::load3(along.tangent) * linear + Float4::load3(along.angular_a) * angular_a
                        + Float4::load3(along.angular_b) * angular_b);
        };
        const float slow[2] = {rows.along[0].rest - apart(rows.along[0]), rows.along[1].rest - apart(rows.along[1])};
        const float before[2] = {rows.impulse[0], rows.impulse[1]};
        float after[2] = {before[0] + (rows.mass_11 * slow[0] + rows.mass_12 * slow[1]),
                          before[1] + (rows.mass_12 * slow[0] + rows.mass_22 * slow[1])};
        if (after[0] * after[0] + after[1] * after[1] > most * most) {
            for (int k = 0; k < 2; ++k) after[k] = before[k] + rows.sliding_mass * slow[k];
            const float length = std::sqrt(after[0] * after[0] + after[1] * after[1]);
            const float part = length > most ? most / length : 1.0f;
            after[0] *= part;
            after[1] *= part;
        }
        rows.impulse[0] = after[0];
        rows.impulse[1] = after[1];
        const float added[2] = {after[0] - before[0], after[1] - before[1]};
        apply(rows, added, changes);
    }
}

void RowSolver::apply(const FrictionRows& rows, const float* impulse, VelocityChange* changes) {
    VelocityChange &a = changes[rows.a], &b = changes[rows.b];
    Float4 linear = Float4::all(0.0f), angular_a = Float4::load(a.angular), angular_b = Float4::load(b.angular);
    for (size_t i = 0; i < 2; ++i) {
        const FrictionRows::Along& along = rows.along[i];
        const Float4 size = Float4::all(impulse[i]);
        linear = linear + Float4::load3(along.tangent) * size;
        angular_a = angular_a + Float4::load3(along.inverse_inertia_angular_a) * size;
        angular_b = angular_b + Float4::load3(along.inverse_inertia_angular_b) * size;
    }
    (Float4::load(a.linear) + linear * Float4::all(rows.inverse_mass_a)).store(a.linear);
    (Float4::load(b.linear) - linear * Float4::all(rows.inverse_mass_b)).store(b.linear);
    angular_a.store(a.angular);
    angular_b.store(b.angular);
}

// J times a change of velocity or a displacement.
inline float RowSolver::along(const Row& row, const VelocityChange* changes) {
    const VelocityChange &a = changes[row.a], &b = changes[row.b];
    return sum3(Float4::load3(row.normal) * (Float4::load(a.linear) - Float4::load(b.linear))
                + Float4::load3(row.angular_a) * Float4::load(a.angular)
                + Float4::load3(row.angular_b) * Float4::load(b.angular));
}

void RowSolver::apply(const Row& row, float impulse, VelocityChange* changes) {
    VelocityChange &a = changes[row.a], &b = changes[row.b];
    const Float4 normal = Float4::load3(row.normal), size = Float4::all(impulse);
    (Float4::load(a.linear) + normal * Float4::all(impulse * row.inverse_mass_a)).store(a.linear);
    (Float4::load(a.angular) + Float4::load3(row.inverse_inertia_angular_a) * size).store(a.angular);
    (Float4::load(b.linear) - normal * Float4::all(impulse * row.inverse_mass_b)).store(b.linear);
    (Float4::load(b.angular) + Float4::load3(row.inverse_inertia_angular_b) * size).store(b.angular);
}

inline void RowSolver::solve_row(Row& row, VelocityChange* changes) {
    const float before = row.impulse;
    row.impulse = std::max(0.0f, before + row.bias - along(row, changes) * row.effective_mass);
    apply(row, row.impulse - before, changes);
}

void RowSolver::solve_bundle(uint32_t bundle, const Substeps& substeps) {
    for (int substep = 0; substep < substeps.count; ++substep) {
        start(bundle, substeps);
        spread(bundle);
        sweep(bundle, substeps.first, Solution::first);
        limit_energy(bundle, substeps);
        joints_->solve(bundle, changes_.data(), Solution::first); // bodies move without opening joints
        move(bundle, substeps.seconds);
        start_second(bundle);
        spread(bundle);
        const bool last = substep + 1 == substeps.count;
        sweep(bundle, last ? substeps.last : substeps.second, Solution::second);
        if (last && start_bounce(bundle)) {
            spread(bundle);
            sweep(bundle, substeps.bounce, Solution::second);
        }
        finish(bundle);
    }
}

// Targets of the first solution, correction of overlap, gravity, and warm starting.
void RowSolver::start(uint32_t bundle, const Substeps& substeps) {
    VelocityChange* const changes = changes_.data();
    for (Row& row : contacts_of(bundle)) {
        const float gap = row.gap + along(row, moved_.data());
        row.bias = row.rest - std::max(gap, 0.0f) / substeps.seconds * row.effective_mass;
        if (const float push = -gap - row.slop; push > 0.0f)
            apply(row, push * substeps.push_part * row.effective_mass, moved_.data());
    }
    static_rows_.start(bundle, substeps, moved_.data());
    joints_->start_substep(bundle, changes, moved_.data());
    const glm::vec3 fall = substeps.fall();
    for (const uint32_t body : bodies_of(bundle))
        if (bodies_[body].inverse_mass > 0.0f)
            for (int axis = 0; axis < 3; ++axis) changes[body].linear[axis] += fall[axis];
    for (const uint32_t body : bodies_of(bundle)) free_changes_[body] = changes[body];
    for (size_t i = begins_[bundle]; i < begins_[bundle + 1]; ++i) {
        apply(contacts_[i], contacts_[i].impulse, changes);
        apply(frictions_[i], frictions_[i].impulse, changes);
    }
    static_rows_.apply(bundle, changes);
}

// Blows are shared by all contacts that they reach (row.h).
void RowSolver::spread(uint32_t bundle) {
    VelocityChange* const changes = changes_.data();
    const std::span<Row> rows = contacts_of(bundle);
    bool any = static_rows_.find_residuals(bundle, changes);
    for (Row& row : rows) {
        const float missing = row.bias - along(row, changes) * row.effective_mass;
        row.residual = blow_speed * row.effective_mass < missing ? missing * row.share : 0.0f;
        any = any || row.residual > 0.0f;
    }
    if (!any) return;
    const auto descent_of = [this](uint32_t body) -> Descent& { return descents_[bundles_.component(body)]; };
    const auto sum = [&](float Descent::*member) {
        for (const Row& row : rows)
            if (row.residual > 0.0f)
                descent_of(row.a).*member +=
                    row.residual * (row.bias - along(row, changes) * row.effective_mass) / row.effective_mass;
        static_rows_.descent(bundle, changes, [&](uint32_t body, float part) { descent_of(body).*member += part; });
    };
    for (const uint32_t body : bodies_of(bundle)) descent_of(body) = {};
    sum(&Descent::start);
    for (const Row& row : rows)
        if (row.residual > 0.0f) apply(row, row.residual, changes);
    static_rows_.add_residuals(bundle, changes);
    sum(&Descent::end);
    for (Row& row : rows) {
        if (!(row.residual > 0.0f)) continue;
        const float factor = descent_of(row.a).factor();
        row.impulse += row.residual * factor;
        apply(row, row.residual * (factor - 1.0f), changes);
    }
    static_rows_.spread(bundle, changes, [&](uint32_t body) { return descent_of(body).factor(); });
}

// The impulses of a substep add no kinetic energy to a component of bodies without joints. Bodies at rest may get as
// much as gravity gives them in a substep, because the impulses that hold up a stack grow from below.
void RowSolver::limit_energy(uint32_t bundle, const Substeps& substeps) {
    const std::span<const uint32_t> bodies = bodies_of(bundle);
    const auto added_of = [this](uint32_t body) -> AddedEnergy& { return added_[bundles_.component(body)]; };
    for (const uint32_t body : bodies) added_of(body) = {};
    const float fall = 0.5f * glm::dot(substeps.fall(), substeps.fall());
    for (const uint32_t body : bodies) {
        const SolverBody& own = bodies_[body];
        const VelocityChange &free = free_changes_[body], &change = changes_[body];
        const glm::vec3 linear = vec3_of(change.linear) - vec3_of(free.linear);
        const glm::vec3 angular = vec3_of(change.angular) - vec3_of(free.angular);
        const glm::vec3 turned(glm::dot(own.inertia[0], angular), glm::dot(own.inertia[1], angular),
                               glm::dot(own.inertia[2], angular)); // N m s
        AddedEnergy& added = added_of(body);
        added.linear += own.mass * glm::dot(own.linear + vec3_of(free.linear), linear)
                        + glm::dot(own.angular + vec3_of(free.angular), turned);
        added.square += 0.5f * (own.mass * glm::dot(linear, linear) + glm::dot(angular, turned));
        added.allowed += jointed_[body] != 0 ? std::numeric_limits<double>::infinity() : own.mass * fall;
    }
    const auto share_of = [&](uint32_t body) { return added_of(body).share(); };
    bool any = false;
    for (const uint32_t body : bodies) {
        const float share = share_of(body);
        if (share == 1.0f) continue;
        any = true;
        const VelocityChange& free = free_changes_[body];
        VelocityChange& change = changes_[body];
        for (int axis = 0; axis < 3; ++axis) {
            change.linear[axis] = free.linear[axis] + share * (change.linear[axis] - free.linear[axis]);
            change.angular[axis] = free.angular[axis] + share * (change.angular[axis] - free.angular[axis]);
        }
    }
    if (!any) return;
    for (size_t i = begins_[bundle]; i < begins_[bundle + 1]; ++i) {
        const float share = share_of(contacts_[i].a);
        contacts_[i].impulse *= share;
        for (float& impulse : frictions_[i].impulse) impulse *= share;
    }
    static_rows_.scale(bundle, share_of);
}

void RowSolver::move(uint32_t bundle, float seconds) {
    for (const uint32_t body : bodies_of(bundle)) {
        const SolverBody& own = bodies_[body];
        for (int axis = 0; axis < 3; ++axis) {
            moved_[body].linear[axis] += (own.linear[axis] + changes_[body].linear[axis]) * seconds;
            moved_[body].angular[axis] += (own.angular[axis] + changes_[body].angular[axis]) * seconds;
        }
    }
}

void RowSolver::start_second(uint32_t bundle) {
    for (Row& row : contacts_of(bundle))
        if (row.impulse > 0.0f) row.bias = row.rest;
    static_rows_.start_second(bundle);
}

bool RowSolver::start_bounce(uint32_t bundle) {
    bool any = static_rows_.start_bounce(bundle);
    for (Row& row : contacts_of(bundle)) {
        if (!(row.bounce > 0.0f) || !(row.impulse + row.total > 0.0f)) continue;
        row.bias = row.rest + row.bounce;
        any = true;
    }
    return any;
}

// As FourChanges::finish().
void RowSolver::finish(uint32_t bundle) {
    for (size_t i = begins_[bundle]; i < begins_[bundle + 1]; ++i) {
        Row& row = contacts_[i];
        const float limit = start_growth * row.start + start_speed * row.effective_mass;
        const float kept = limit < row.impulse ? limit / row.impulse : 1.0f;
        row.total += row.impulse;
        if (row.total > 0.0f || row.gap + row.slop < 0.0f) acted_[row.a] = acted_[row.b] = 1;
        row.impulse = row.start = row.impulse * kept;
        for (int k = 0; k < 2; ++k) {
            frictions_[i].total[k] += frictions_[i].impulse[k];
            frictions_[i].impulse[k] *= kept;
        }
    }
    static_rows_.finish(bundle, acted_.data());
    joints_->finish_substep(bundle);
}

std::span<Row> RowSolver::contacts_of(uint32_t bundle) {
    return std::span(contacts_).subspan(begins_[bundle], begins_[bundle + 1] - begins_[bundle]);
}

std::span<const uint32_t> RowSolver::bodies_of(uint32_t bundle) const {
    return std::span(bundle_bodies_)
        .subspan(bundle_begins_[bundle], bundle_begins_[bundle + 1] - bundle_begins_[bundle]);
}

void RowSolver::sweep(uint32_t bundle, int count, Solution solution) {
    VelocityChange* const changes = changes_.data();
    const size_t begin = begins_[bundle], end = begins_[bundle + 1];
    const std::span<Row> contacts = std::span(contacts_).subspan(begin, end - begin);
    for (int sweep = 0; sweep < count; ++sweep) {
        joints_->solve(bundle, changes, solution);
        solve_contacts(contacts, changes);
        static_rows_.solve_contacts(bundle, changes);
        solve_friction(begin, end);
        static_rows_.solve_friction(bundle, changes);
    }
}

} // namespace brittle::physics
