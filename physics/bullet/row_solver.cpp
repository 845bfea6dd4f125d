#include "physics/bullet/row_solver.h"

#include <algorithm>
#include <limits>

#include "physics/bullet/float4.h"

namespace brittle::physics {

namespace {

// Points of one pair of bodies that are told apart; a hull has up to twelve on the ground, and more only as a compound.
constexpr uint32_t most_points = 32;
// Of how hard a contact presses.
constexpr float no_limit = std::numeric_limits<float>::max();

void put(float* to, const btVector3& from) {
    for (int axis = 0; axis < 3; ++axis) to[axis] = from[axis];
}
void put4(float* to, const btVector3& from) {
    put(to, from);
    to[3] = 0.0f;
}
btVector3 vector(const float* from) {
    return {from[0], from[1], from[2]};
}

bool never_moves(const btSolverBody& body) {
    return body.m_originalBody == nullptr;
}

} // namespace

void RowSolver::solve(btAlignedObjectArray<btSolverBody>& bodies, btConstraintArray& contacts,
                      btConstraintArray& frictions, int sweeps) {
    order(bodies, contacts);
    move_apart(bodies, contacts, sweeps);

    motions_.resize(static_cast<size_t>(bodies.size()));
    for (int i = 0; i < bodies.size(); ++i) {
        put4(motions_[static_cast<size_t>(i)].linear, bodies[i].internalGetDeltaLinearVelocity());
        put4(motions_[static_cast<size_t>(i)].angular, bodies[i].internalGetDeltaAngularVelocity());
    }
    contacts_.clear();
    for (const uint32_t index : order_) contacts_.push_back(row_of(contacts[static_cast<int>(index)], bodies));
    held_ = first_held(contacts_);
    // Bullet makes one friction row a contact, in their order.
    const auto friction_count = static_cast<uint32_t>(frictions.size());
    frictions_.clear();
    of_friction_.clear();
    for (const uint32_t index : order_) {
        if (index >= friction_count) continue;
        const btSolverConstraint& friction = frictions[static_cast<int>(index)];
        frictions_.push_back(row_of(friction, bodies));
        of_friction_.push_back(place_[static_cast<size_t>(friction.m_frictionIndex)]);
    }

    for (int sweep = 0; sweep < sweeps; ++sweep) {
        press();
        rub();
    }

    for (size_t i = 0; i < order_.size(); ++i)
        contacts[static_cast<int>(order_[i])].m_appliedImpulse = contacts_[i].impulse;
    for (size_t i = 0, next = 0; i < order_.size(); ++i)
        if (order_[i] < friction_count) frictions[static_cast<int>(order_[i])].m_appliedImpulse = frictions_[next++].impulse;
    for (int i = 0; i < bodies.size(); ++i) {
        bodies[i].internalGetDeltaLinearVelocity() = vector(motions_[static_cast<size_t>(i)].linear);
        bodies[i].internalGetDeltaAngularVelocity() = vector(motions_[static_cast<size_t>(i)].angular);
    }
}

void RowSolver::press() {
    Motion* const motions = motions_.data();
    for (size_t i = 0; i < held_; ++i) resolve(contacts_[i], motions, 0.0f, no_limit);
    for (size_t i = held_; i < contacts_.size(); ++i) resolve_held(contacts_[i], motions, 0.0f, no_limit);
}

void RowSolver::rub() {
    Motion* const motions = motions_.data();
    for (size_t i = 0; i < frictions_.size(); ++i) {
        const float pressing = contacts_[of_friction_[i]].impulse;
        if (pressing <= 0.0f) continue;
        const float most = frictions_[i].friction * pressing;
        if (frictions_[i].light_b > 0.0f)
            resolve(frictions_[i], motions, -most, most);
        else
            resolve_held(frictions_[i], motions, -most, most);
    }
}

// They are behind all others.
size_t RowSolver::first_held(const std::vector<Row>& rows) {
    return static_cast<size_t>(
        std::ranges::partition_point(rows, [](const Row& row) { return row.light_b > 0.0f; }) - rows.begin());
}

// By whether a body never moves, then by the place among the points of the same two bodies: a sort by counting.
void RowSolver::order(const btAlignedObjectArray<btSolverBody>& bodies, const btConstraintArray& contacts) {
    keys_.clear();
    starts_.assign(2 * most_points + 1, 0);
    for (int i = 0, point = 0; i < contacts.size(); ++i) {
        const btSolverConstraint& row = contacts[i];
        const bool same = i > 0 && contacts[i - 1].m_solverBodyIdA == row.m_solverBodyIdA
                          && contacts[i - 1].m_solverBodyIdB == row.m_solverBodyIdB;
        point = same ? point + 1 : 0;
        const bool held = never_moves(bodies[row.m_solverBodyIdA]) || never_moves(bodies[row.m_solverBodyIdB]);
        keys_.push_back((held ? most_points : 0) + std::min(static_cast<uint32_t>(point), most_points - 1));
        ++starts_[keys_.back() + 1];
    }
    for (size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    order_.resize(keys_.size());
    place_.resize(keys_.size());
    for (uint32_t i = 0; i < keys_.size(); ++i) {
        place_[i] = starts_[keys_[i]]++;
        order_[place_[i]] = i;
    }
}

RowSolver::Row RowSolver::row_of(const btSolverConstraint& from, const btAlignedObjectArray<btSolverBody>& bodies) {
    const btSolverBody &first = bodies[from.m_solverBodyIdA], &second = bodies[from.m_solverBodyIdB];
    const bool turned = never_moves(first);
    Row row;
    // Of a body that never moves, Bullet leaves the normal out.
    put(row.normal, turned ? from.m_contactNormal2 : from.m_contactNormal1);
    put(row.arm_a, turned ? from.m_relpos2CrossNormal : from.m_relpos1CrossNormal);
    put(row.arm_b, turned ? from.m_relpos1CrossNormal : from.m_relpos2CrossNormal);
    put(row.turn_a, turned ? from.m_angularComponentB : from.m_angularComponentA);
    put(row.turn_b, turned ? from.m_angularComponentA : from.m_angularComponentB);
    row.a = static_cast<uint32_t>(turned ? from.m_solverBodyIdB : from.m_solverBodyIdA);
    row.b = static_cast<uint32_t>(turned ? from.m_solverBodyIdA : from.m_solverBodyIdB);
    row.light_a = (turned ? second : first).internalGetInvMass().x();
    row.light_b = (turned ? first : second).internalGetInvMass().x();
    row.wanted = from.m_rhs;
    row.gain = from.m_jacDiagABInv;
    row.softness = from.m_cfm;
    row.impulse = from.m_appliedImpulse;
    row.friction = from.m_friction;
    return row;
}

inline void RowSolver::resolve(Row& row, Motion* motions, float low, float high) {
    Motion &a = motions[row.a], &b = motions[row.b];
    const Float4 normal = Float4::load3(row.normal);
    const Float4 linear_a = Float4::load(a.linear), linear_b = Float4::load(b.linear);
    const Float4 angular_a = Float4::load(a.angular), angular_b = Float4::load(b.angular);
    const float apart = sum3(normal * (linear_a - linear_b) + Float4::load3(row.arm_a) * angular_a
                             + Float4::load3(row.arm_b) * angular_b);
    const float before = row.impulse;
    const float after = std::clamp(before + row.wanted - before * row.softness - apart * row.gain, low, high);
    row.impulse = after;
    const float change = after - before;
    (linear_a + normal * Float4::all(change * row.light_a)).store(a.linear);
    (linear_b - normal * Float4::all(change * row.light_b)).store(b.linear);
    (angular_a + Float4::load3(row.turn_a) * Float4::all(change)).store(a.angular);
    (angular_b + Float4::load3(row.turn_b) * Float4::all(change)).store(b.angular);
}

// Where b never moves, it is neither read nor written: all that lie on the ground would wait for each other.
inline void RowSolver::resolve_held(Row& row, Motion* motions, float low, float high) {
    Motion& a = motions[row.a];
    const Float4 normal = Float4::load3(row.normal);
    const Float4 linear = Float4::load(a.linear), angular = Float4::load(a.angular);
    const float apart = sum3(normal * linear + Float4::load3(row.arm_a) * angular);
    const float before = row.impulse;
    const float after = std::clamp(before + row.wanted - before * row.softness - apart * row.gain, low, high);
    row.impulse = after;
    (linear + normal * Float4::all((after - before) * row.light_a)).store(a.linear);
    (angular + Float4::load3(row.turn_a) * Float4::all(after - before)).store(a.angular);
}

// The same with velocities of their own that only move the bodies and are then forgotten.
void RowSolver::move_apart(btAlignedObjectArray<btSolverBody>& bodies, btConstraintArray& contacts, int sweeps) {
    deep_.clear();
    contacts_.clear();
    for (const uint32_t index : order_) {
        const btSolverConstraint& contact = contacts[static_cast<int>(index)];
        if (contact.m_rhsPenetration == 0.0f) continue;
        deep_.push_back(index);
        contacts_.push_back(row_of(contact, bodies));
        contacts_.back().wanted = contact.m_rhsPenetration;
        contacts_.back().impulse = contact.m_appliedPushImpulse;
    }
    if (deep_.empty()) return;
    motions_.resize(static_cast<size_t>(bodies.size()));
    for (int i = 0; i < bodies.size(); ++i) {
        put4(motions_[static_cast<size_t>(i)].linear, bodies[i].internalGetPushVelocity());
        put4(motions_[static_cast<size_t>(i)].angular, bodies[i].internalGetTurnVelocity());
    }
    held_ = first_held(contacts_);
    for (int sweep = 0; sweep < sweeps; ++sweep) press();
    for (size_t i = 0; i < deep_.size(); ++i)
        contacts[static_cast<int>(deep_[i])].m_appliedPushImpulse = contacts_[i].impulse;
    for (int i = 0; i < bodies.size(); ++i) {
        if (never_moves(bodies[i])) continue;
        bodies[i].internalGetPushVelocity() = vector(motions_[static_cast<size_t>(i)].linear);
        bodies[i].internalGetTurnVelocity() = vector(motions_[static_cast<size_t>(i)].angular);
    }
}

} // namespace brittle::physics
