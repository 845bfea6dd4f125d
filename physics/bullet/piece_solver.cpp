#include "physics/bullet/piece_solver.h"

#include <algorithm>
#include <cassert>

namespace brittle::physics {

namespace {

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
    const auto ground =
        std::stable_partition(ordered_.begin(), ordered_.end(), [](const btPersistentManifold* manifold) {
            return !manifold->getBody0()->isStaticObject() && !manifold->getBody1()->isStaticObject();
        });
    const btScalar deepest = -separation_speed_ * bullet_units * info.m_timeStep / info.m_erp2;
    for (auto between = ordered_.begin(); between != ordered_.end(); ++between) {
        if (between >= ground && on_ground(**between)) continue;
        for (int i = 0; i < (*between)->getNumContacts(); ++i) {
            btManifoldPoint& point = (*between)->getContactPoint(i);
            point.m_distance1 = std::max(point.m_distance1, deepest);
        }
    }
    note_speeds();
    const btScalar result = btSequentialImpulseConstraintSolver::solveGroup(
        bodies, body_count, ordered_.data(), manifold_count, constraints, constraint_count, info, drawer,
        dispatcher);
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
    for (const btPersistentManifold* manifold : ordered_)
        for (int i = 0; i < manifold->getNumContacts(); ++i) {
            const btManifoldPoint& point = manifold->getContactPoint(i);
            const float speed = speeds_[next++];
            if (point.m_appliedImpulse > 0.0f) contacts.push_back(contact_of(*manifold, point, speed));
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
    contact.point = metres_from_bullet(point.getPositionWorldOnB());
    contact.normal = to_glm(point.m_normalWorldOnB);
    contact.impulse = point.m_appliedImpulse / bullet_units;
    contact.friction = metres_from_bullet(point.m_lateralFrictionDir1 * point.m_appliedImpulseLateral1);
    contact.speed = speed;
    return contact;
}

} // namespace brittle::physics
