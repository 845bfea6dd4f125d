#include "physics/bullet/piece_solver.h"

#include <algorithm>
#include <cassert>

namespace brittle::physics {

namespace {

// Contacts that were closing faster than this, in m/s, are blows. The next step's solution starts from the impulses of the
// last one's, and what stopped a blow is a hundred times what will be needed: what the sweeps do not get rid of
// would be energy from nothing.
constexpr float blow_speed = 0.2f;

bool on_ground(const btPersistentManifold& manifold) {
    return manifold.getBody0()->getUserIndex() < 0 || manifold.getBody1()->getUserIndex() < 0;
}
btVector3 velocity_at(const btCollisionObject& object, const btVector3& point) {
    const btRigidBody& rigid = *btRigidBody::upcast(&object);
    return rigid.getVelocityInLocalPoint(point - rigid.getCenterOfMassPosition());
}

bool rests(const btCollisionObject& object) {
    return object.isStaticObject() || !object.isActive();
}

} // namespace

btScalar PieceSolver::solveGroup(btCollisionObject** bodies, int body_count, btPersistentManifold** manifolds,
                                 int manifold_count, btTypedConstraint** constraints, int constraint_count,
                                 const btContactSolverInfo& info, btIDebugDraw* drawer,
                                 btDispatcher* dispatcher) {
    ordered_.assign(manifolds, manifolds + manifold_count);
    std::stable_partition(ordered_.begin(), ordered_.end(), [](const btPersistentManifold* manifold) {
        return !manifold->getBody0()->isStaticObject() && !manifold->getBody1()->isStaticObject();
    });
    note_speeds();
    prepare_contacts(separation_speed_ * bullet_units * info.m_timeStep / info.m_erp2);
    const btScalar result = btSequentialImpulseConstraintSolver::solveGroup(
        bodies, body_count, ordered_.data(), manifold_count, constraints, constraint_count, info, drawer,
        dispatcher);
    put_off_repairs(bodies, body_count);
    report_contacts();
    return result;
}

btScalar PieceSolver::solveGroupCacheFriendlyIterations(btCollisionObject**, int, btPersistentManifold**, int,
                                                        btTypedConstraint**, int, const btContactSolverInfo& info,
                                                        btIDebugDraw*) {
    assert(m_tmpSolverNonContactConstraintPool.size() == 0 && "no joints");
    assert(m_tmpSolverContactRollingFrictionConstraintPool.size() == 0 && "no rolling friction");
    rows_.solve(m_tmpSolverBodyPool, m_tmpSolverContactConstraintPool, m_tmpSolverContactFrictionConstraintPool,
                info.m_numIterations);
    return 0.0f;
}

// What presses among those that sleep stays as it is until one of them wakes, comes or goes.
void PieceSolver::report_sleeping(btDispatcher& dispatcher) {
    if (find_resting()) {
        resting_contacts_.clear();
        for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
            const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
            if (!rests(*manifold.getBody0()) || !rests(*manifold.getBody1())) continue;
            for (int p = 0; p < manifold.getNumContacts(); ++p)
                if (manifold.getContactPoint(p).m_appliedImpulse > 0.0f)
                    resting_contacts_.push_back(contact_of(manifold, manifold.getContactPoint(p), 0.0f));
        }
    }
    contacts.insert(contacts.end(), resting_contacts_.begin(), resting_contacts_.end());
}

bool PieceSolver::find_resting() {
    bool changed = resting_.size() != bodies_.size();
    resting_.resize(bodies_.size());
    for (size_t i = 0; i < bodies_.size(); ++i) {
        const Resting now{bodies_[i]->id, rests(*bodies_[i]->rigid)};
        changed = changed || now != resting_[i];
        resting_[i] = now;
    }
    return changed;
}

// Bullet pushes each body at its own side of a gap or an overlap, and friction then turns the two by more than it should:
// what moves meets in one point.
void PieceSolver::prepare_contacts(btScalar deepest) {
    for (btPersistentManifold* manifold : ordered_) {
        if (on_ground(*manifold)) continue;
        const bool one = !manifold->getBody0()->isStaticObject() && !manifold->getBody1()->isStaticObject();
        for (int i = 0; i < manifold->getNumContacts(); ++i) {
            btManifoldPoint& point = manifold->getContactPoint(i);
            point.m_distance1 = std::max(point.m_distance1, -deepest);
            if (!one) continue;
            point.m_positionWorldOnA = 0.5f * (point.m_positionWorldOnA + point.m_positionWorldOnB);
            point.m_positionWorldOnB = point.m_positionWorldOnA;
        }
    }
}

void PieceSolver::put_off_repairs(btCollisionObject** bodies, int body_count) {
    for (int i = 0; i < body_count; ++i) {
        if (bodies[i]->isStaticObject()) continue;
        BodyRecord& body = *bodies_[static_cast<size_t>(bodies[i]->getUserIndex())];
        const btTransform& moved = body.rigid->getWorldTransform();
        const btTransform& before = body.stepped_from;
        body.repaired = !(moved == before);
        if (!body.repaired) continue;
        body.repair = btTransform(moved.getRotation() * before.getRotation().inverse(), moved.getOrigin() - before.getOrigin());
        body.rigid->setWorldTransform(before);
    }
}

void PieceSolver::note_speeds() {
    speeds_.clear();
    for (const btPersistentManifold* manifold : ordered_)
        for (int i = 0; i < manifold->getNumContacts(); ++i) {
            const btManifoldPoint& point = manifold->getContactPoint(i);
            const btVector3 apart = velocity_at(*manifold->getBody0(), point.getPositionWorldOnA())
                                    - velocity_at(*manifold->getBody1(), point.getPositionWorldOnB());
            speeds_.push_back(-apart.dot(point.m_normalWorldOnB) / bullet_units);
        }
}
void PieceSolver::report_contacts() {
    size_t next = 0;
    for (btPersistentManifold* manifold : ordered_)
        for (int i = 0; i < manifold->getNumContacts(); ++i) {
            btManifoldPoint& point = manifold->getContactPoint(i);
            const float speed = speeds_[next++];
            // Bullet leaves a point its friction when the last sweep takes the pressure from it.
            if (point.m_appliedImpulse > 0.0f || point.m_appliedImpulseLateral1 != 0.0f)
                contacts.push_back(contact_of(*manifold, point, speed));
            if (speed > blow_speed)
                point.m_appliedImpulse = point.m_appliedImpulseLateral1 = point.m_appliedImpulseLateral2 = 0.0f;
        }
}
Contact PieceSolver::contact_of(const btPersistentManifold& manifold, const btManifoldPoint& point,
                                float speed) const {
    Contact contact;
    const int first = manifold.getBody0()->getUserIndex(), second = manifold.getBody1()->getUserIndex();
    // Bullet's index is that of the hull in a compound, -1 without; ground_contact.cpp needs it itself.
    const int part_a = on_ground(manifold) ? point.m_partId0 : point.m_index0;
    if (first >= 0) contact.a = bodies_[static_cast<size_t>(first)]->id;
    if (second >= 0) contact.b = bodies_[static_cast<size_t>(second)]->id;
    contact.part_a = static_cast<uint32_t>(std::max(part_a, 0));
    contact.part_b = second >= 0 ? static_cast<uint32_t>(std::max(point.m_index1, 0)) : 0;
    // Where it acts on what moves.
    const bool b_moves = !manifold.getBody1()->isStaticObject();
    contact.point = metres_from_bullet(b_moves ? point.getPositionWorldOnB() : point.getPositionWorldOnA());
    contact.normal = to_glm(point.m_normalWorldOnB);
    contact.impulse = point.m_appliedImpulse / bullet_units;
    contact.blow = contact.impulse;
    contact.gap = point.getDistance() / bullet_units;
    contact.friction = metres_from_bullet(point.m_lateralFrictionDir1 * point.m_appliedImpulseLateral1);
    contact.speed = speed;
    return contact;
}

} // namespace brittle::physics
