#include "physics/bullet/row_solver.h"

#include <algorithm>
#include <limits>

#include "physics/bullet/float4.h"

namespace brittle::physics {

namespace {

// Points of one pair of bodies that are told apart; a hull has up to twelve on the ground, and more only as a compound.
constexpr uint32_t most_points = 32;

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
        for (Row& row : contacts_) resolve(row, motions_.data(), 0.0f, std::numeric_limits<float>::max());
        for (size_t i = 0; i < frictions_.size(); ++i) {
            const float pressing = contacts_[of_friction_[i]].impulse;
            if (pressing <= 0.0f) continue;
            const float most = frictions_[i].friction * pressing;
            resolve(frictions_[i], motions_.data(), -most, most);
        }
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
    Row row;
    // Bullet leaves out what belongs to a body that never moves.
    put(row.normal, never_moves(bodies[from.m_solverBodyIdA]) ? -from.m_contactNormal2 : from.m_contactNormal1);
    put(row.arm_a, from.m_relpos1CrossNormal);
    put(row.arm_b, from.m_relpos2CrossNormal);
    put(row.turn_a, from.m_angularComponentA);
    put(row.turn_b, from.m_angularComponentB);
    row.wanted = from.m_rhs;
    row.gain = from.m_jacDiagABInv;
    row.softness = from.m_cfm;
    row.impulse = from.m_appliedImpulse;
    row.friction = from.m_friction;
    row.a = static_cast<uint32_t>(from.m_solverBodyIdA);
    row.b = static_cast<uint32_t>(from.m_solverBodyIdB);
    row.light_a = bodies[from.m_solverBodyIdA].internalGetInvMass().x();
    row.light_b = bodies[from.m_solverBodyIdB].internalGetInvMass().x();
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
    for (int sweep = 0; sweep < sweeps; ++sweep)
        for (Row& row : contacts_) resolve(row, motions_.data(), 0.0f, std::numeric_limits<float>::max());
    for (size_t i = 0; i < deep_.size(); ++i)
        contacts[static_cast<int>(deep_[i])].m_appliedPushImpulse = contacts_[i].impulse;
    for (int i = 0; i < bodies.size(); ++i) {
        if (never_moves(bodies[i])) continue;
        bodies[i].internalGetPushVelocity() = vector(motions_[static_cast<size_t>(i)].linear);
        bodies[i].internalGetTurnVelocity() = vector(motions_[static_cast<size_t>(i)].angular);
    }
}

} // namespace brittle::physics
