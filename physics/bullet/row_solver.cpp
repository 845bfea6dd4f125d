#include "physics/bullet/row_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "physics/bullet/float4.h"

namespace brittle::physics {

namespace {

// Points of one pair of bodies that are told apart; a hull has up to twelve on the ground, and more only as a compound.
constexpr uint32_t most_points = 32;
// Of how hard a contact presses.
constexpr float no_limit = std::numeric_limits<float>::max();
// The part of its last impulse from which a contact starts.
constexpr float kept_impulse = 0.85f;
// The part of an overlap that is undone in a step, and by how much less by turning than by moving.
constexpr float undone_part = 0.2f;
constexpr float undone_by_turning = 0.1f;
// Contacts that were closing faster than this, in m/s, are blows. The next step's solution starts from the impulses of the
// last one's, and what stopped a blow is a hundred times what will be needed: what the sweeps do not get rid of
// would be energy from nothing.
constexpr float blow_speed = 0.2f;

void put(float* to, const btVector3& from) {
    for (int axis = 0; axis < 3; ++axis) to[axis] = from[axis];
}
btVector3 vector(const float* from) {
    return {from[0], from[1], from[2]};
}
bool never_moves(const btCollisionObject* object) {
    return object->isStaticObject();
}

} // namespace

void RowSolver::solve(std::span<BodyRecord* const> bodies, std::span<btPersistentManifold* const> manifolds,
                      const Step& step) {
    take_bodies(bodies, step);
    order(manifolds);
    make_rows(manifolds, step);
    move_apart(bodies, step);

    motions_.assign(movers_.size(), {});
    for (size_t i = 0; i < contacts_.size(); ++i) give(contacts_[i], contacts_[i].impulse, i >= held_, motions_.data());
    for (int sweep = 0; sweep < step.sweeps; ++sweep) {
        press(contacts_, held_, motions_.data());
        rub();
    }
    hand_back(bodies);
}

void RowSolver::take_bodies(std::span<BodyRecord* const> bodies, const Step& step) {
    movers_.clear();
    for (const BodyRecord* body : bodies) {
        const btRigidBody& rigid = *body->rigid;
        const auto user = static_cast<size_t>(rigid.getUserIndex());
        if (user >= indices_.size()) indices_.resize(user + 1);
        indices_[user] = static_cast<uint32_t>(movers_.size());
        if (body->resting) {
            movers_.push_back({{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, rigid.getCenterOfMassPosition(), {0, 0, 0}, {0, 0, 0}, 0.0f});
            continue;
        }
        const btMatrix3x3& turning = rigid.getInvInertiaTensorWorld();
        movers_.push_back({{turning[0], turning[1], turning[2]},
                           rigid.getCenterOfMassPosition(),
                           rigid.getLinearVelocity() + step.gravity * step.seconds,
                           rigid.getAngularVelocity(),
                           rigid.getInvMass()});
    }
}

// A sort by counting.
void RowSolver::order(std::span<btPersistentManifold* const> manifolds) {
    keys_.clear();
    starts_.assign(2 * most_points + 1, 0);
    const btPersistentManifold* before = nullptr;
    uint32_t place = 0; // among the points of the same two bodies
    for (const btPersistentManifold* manifold : manifolds) {
        const btCollisionObject *a = manifold->getBody0(), *b = manifold->getBody1();
        if (!before || before->getBody0() != a || before->getBody1() != b) place = 0;
        before = manifold;
        const uint32_t first_key = never_moves(a) || never_moves(b) ? most_points : 0;
        for (int i = 0; i < manifold->getNumContacts(); ++i, ++place) {
            keys_.push_back(first_key + std::min(place, most_points - 1));
            ++starts_[keys_.back() + 1];
        }
    }
    for (size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    held_ = starts_[most_points];
    places_.resize(keys_.size());
    for (size_t i = 0; i < keys_.size(); ++i) places_[i] = starts_[keys_[i]]++;
}

void RowSolver::make_rows(std::span<btPersistentManifold* const> manifolds, const Step& step) {
    contacts_.resize(places_.size());
    frictions_.resize(places_.size());
    coefficients_.resize(places_.size());
    depths_.resize(places_.size());
    solved_.clear();
    // What is deeper than a step may undo counts as that deep.
    const float deepest = step.separation_speed * step.seconds / undone_part;
    for (btPersistentManifold* manifold : manifolds) {
        const btCollisionObject *a = manifold->getBody0(), *b = manifold->getBody1();
        const bool held = never_moves(a) || never_moves(b), ground = a->getUserIndex() < 0 || b->getUserIndex() < 0;
        for (int i = 0; i < manifold->getNumContacts(); ++i) {
            btManifoldPoint& point = manifold->getContactPoint(i);
            const btVector3 &on_a = point.getPositionWorldOnA(), &on_b = point.getPositionWorldOnB();
            solved_.push_back({.manifold = manifold,
                               .point = &point,
                               .position = !held ? 0.5f * (on_a + on_b) : never_moves(b) ? on_a : on_b,
                               .distance = ground ? point.getDistance() : std::max(point.getDistance(), -deepest),
                               .speed = 0.0f,
                               .impulse = 0.0f,
                               .friction = {0, 0, 0}});
            make_rows(solved_.back(), places_[solved_.size() - 1], step);
        }
    }
}

RowSolver::Side RowSolver::side_of(const btCollisionObject* object, const btVector3& position) const {
    if (never_moves(object)) return {nullptr, 0, {0, 0, 0}};
    const uint32_t index = indices_[static_cast<size_t>(object->getUserIndex())];
    return {&movers_[index], index, position - movers_[index].centre};
}

// Of the two bodies a is the one that moves, where one does not.
RowSolver::Row RowSolver::row_along(const btVector3& normal, const Side& a, const Side& b) {
    Row row{};
    float response = a.mover->light;
    const auto turn_of = [](const Mover& mover, const btVector3& arm) {
        return btVector3(mover.turning[0].dot(arm), mover.turning[1].dot(arm), mover.turning[2].dot(arm));
    };
    put(row.normal, normal);
    const btVector3 arm_a = a.arm.cross(normal), turn_a = turn_of(*a.mover, arm_a);
    put(row.arm_a, arm_a);
    put(row.turn_a, turn_a);
    response += turn_a.dot(arm_a);
    row.a = a.index;
    row.light_a = a.mover->light;
    float apart = normal.dot(a.mover->linear) + arm_a.dot(a.mover->angular);
    if (b.mover) {
        const btVector3 arm_b = normal.cross(b.arm), turn_b = turn_of(*b.mover, arm_b);
        put(row.arm_b, arm_b);
        put(row.turn_b, turn_b);
        response += b.mover->light + turn_b.dot(arm_b);
        row.b = b.index;
        row.light_b = b.mover->light;
        apart += arm_b.dot(b.mover->angular) - normal.dot(b.mover->linear);
    }
    row.gain = response > 0.0f ? 1.0f / response : 0.0f;
    row.wanted = -apart * row.gain;
    return row;
}

void RowSolver::make_rows(Solved& contact, size_t place, const Step& step) {
    const btManifoldPoint& point = *contact.point;
    Side a = side_of(contact.manifold->getBody0(), contact.position);
    Side b = side_of(contact.manifold->getBody1(), contact.position);
    const bool turned = !a.mover;
    if (turned) std::swap(a, b);
    const btVector3 normal = turned ? -point.m_normalWorldOnB : point.m_normalWorldOnB;

    Row& row = contacts_[place];
    row = row_along(normal, a, b);
    // Between those that rest, or where one does on what never moves: all stays as it is.
    const bool still = row.gain == 0.0f;
    const float apart = still ? 0.0f : -row.wanted / row.gain;
    // Before the step's gravity, which is the same for both where both move.
    const float before = b.mover || still ? apart : apart - normal.dot(step.gravity) * step.seconds;
    contact.speed = -before;
    const float bounce =
        std::abs(before) < step.least_bounce_speed ? 0.0f : std::max(0.0f, -before * point.m_combinedRestitution);
    row.wanted += (bounce - std::max(contact.distance, 0.0f) / step.seconds) * row.gain;
    row.impulse = point.m_appliedImpulse * (still ? 1.0f : kept_impulse);
    const float undone = (point.m_contactPointFlags & BT_CONTACT_FLAG_HAS_CONTACT_ERP) != 0 ? point.m_contactERP : undone_part;
    depths_[place] = std::max(-contact.distance, 0.0f) * undone / step.seconds * row.gain;

    btVector3 sliding = a.mover->linear + a.mover->angular.cross(a.arm);
    if (b.mover) sliding -= b.mover->linear + b.mover->angular.cross(b.arm);
    sliding -= normal * apart;
    btVector3 along;
    if (still && point.m_lateralFrictionDir1.length2() > 0.5f)
        along = turned ? -point.m_lateralFrictionDir1 : point.m_lateralFrictionDir1;
    else if (const float square = sliding.length2(); square > SIMD_EPSILON)
        along = sliding / std::sqrt(square);
    else {
        // Points beside each other take turns, so that together they hold both ways.
        btVector3 across;
        btPlaneSpace1(normal, along, across);
        if ((&point - &contact.manifold->getContactPoint(0)) % 2 != 0) along = across;
    }
    frictions_[place] = row_along(along, a, b);
    if (still) frictions_[place].impulse = point.m_appliedImpulseLateral1;
    coefficients_[place] = point.m_combinedFriction;
}

void RowSolver::press(std::vector<Row>& rows, size_t held, Motion* motions) {
    for (size_t i = 0; i < held; ++i) resolve(rows[i], motions, 0.0f, no_limit);
    for (size_t i = held; i < rows.size(); ++i) resolve_held(rows[i], motions, 0.0f, no_limit);
}

void RowSolver::rub() {
    Motion* const motions = motions_.data();
    for (size_t i = 0; i < frictions_.size(); ++i) {
        const float most = coefficients_[i] * contacts_[i].impulse;
        if (most <= 0.0f && frictions_[i].impulse == 0.0f) continue;
        if (i < held_)
            resolve(frictions_[i], motions, -most, most);
        else
            resolve_held(frictions_[i], motions, -most, most);
    }
}

void RowSolver::give(const Row& row, float impulse, bool held, Motion* motions) {
    Motion& a = motions[row.a];
    (Float4::load(a.linear) + Float4::load3(row.normal) * Float4::all(impulse * row.light_a)).store(a.linear);
    (Float4::load(a.angular) + Float4::load3(row.turn_a) * Float4::all(impulse)).store(a.angular);
    if (held) return;
    Motion& b = motions[row.b];
    (Float4::load(b.linear) - Float4::load3(row.normal) * Float4::all(impulse * row.light_b)).store(b.linear);
    (Float4::load(b.angular) + Float4::load3(row.turn_b) * Float4::all(impulse)).store(b.angular);
}

inline void RowSolver::resolve(Row& row, Motion* motions, float low, float high) {
    const Motion &a = motions[row.a], &b = motions[row.b];
    const float apart = sum3(Float4::load3(row.normal) * (Float4::load(a.linear) - Float4::load(b.linear))
                             + Float4::load3(row.arm_a) * Float4::load(a.angular)
                             + Float4::load3(row.arm_b) * Float4::load(b.angular));
    const float before = row.impulse;
    row.impulse = std::clamp(before + row.wanted - apart * row.gain, low, high);
    give(row, row.impulse - before, false, motions);
}

// Where b never moves, it is neither read nor written: all that lie on the ground would wait for each other.
inline void RowSolver::resolve_held(Row& row, Motion* motions, float low, float high) {
    const Motion& a = motions[row.a];
    const float apart = sum3(Float4::load3(row.normal) * Float4::load(a.linear)
                             + Float4::load3(row.arm_a) * Float4::load(a.angular));
    const float before = row.impulse;
    row.impulse = std::clamp(before + row.wanted - apart * row.gain, low, high);
    give(row, row.impulse - before, true, motions);
}

// With velocities of their own that only move the bodies and are then forgotten.
void RowSolver::move_apart(std::span<BodyRecord* const> bodies, const Step& step) {
    deep_.clear();
    size_t held = 0;
    for (size_t i = 0; i < contacts_.size(); ++i) {
        if (i == held_) held = deep_.size();
        if (depths_[i] == 0.0f) continue;
        deep_.push_back(contacts_[i]);
        deep_.back().wanted = depths_[i];
        deep_.back().impulse = 0.0f;
    }
    if (held_ == contacts_.size()) held = deep_.size();
    for (BodyRecord* body : bodies) body->repaired = false;
    if (deep_.empty()) return;
    motions_.assign(movers_.size(), {});
    for (int sweep = 0; sweep < step.sweeps; ++sweep) press(deep_, held, motions_.data());
    for (size_t i = 0; i < bodies.size(); ++i) {
        const btVector3 way = vector(motions_[i].linear) * step.seconds;
        const btVector3 turn = vector(motions_[i].angular) * (undone_by_turning * step.seconds);
        const float angle = turn.length();
        bodies[i]->repaired = angle > 0.0f || way.length2() > 0.0f;
        bodies[i]->repair.setOrigin(way);
        bodies[i]->repair.setRotation(angle > 0.0f ? btQuaternion(turn / angle, angle) : btQuaternion::getIdentity());
    }
}

void RowSolver::hand_back(std::span<BodyRecord* const> bodies) {
    for (size_t i = 0; i < bodies.size(); ++i) {
        bodies[i]->rigid->setLinearVelocity(movers_[i].linear + vector(motions_[i].linear));
        bodies[i]->rigid->setAngularVelocity(movers_[i].angular + vector(motions_[i].angular));
    }
    for (size_t i = 0; i < solved_.size(); ++i) {
        Solved& contact = solved_[i];
        btManifoldPoint& point = *contact.point;
        const Row& friction = frictions_[places_[i]];
        const bool turned = never_moves(contact.manifold->getBody0());
        point.m_lateralFrictionDir1 = turned ? -vector(friction.normal) : vector(friction.normal);
        contact.impulse = contacts_[places_[i]].impulse;
        contact.friction = point.m_lateralFrictionDir1 * friction.impulse;
        const bool blow = contact.speed > blow_speed * bullet_units;
        point.m_appliedImpulse = blow ? 0.0f : contact.impulse;
        point.m_appliedImpulseLateral1 = blow ? 0.0f : friction.impulse;
    }
}

} // namespace brittle::physics
