#include "physics/bullet/stepped_world.h"

#include <algorithm>
#include <cmath>

namespace brittle::physics {

namespace {

// How much of its velocity a body keeps per second while it settles: half a second of it takes jitter to
// nothing.
constexpr float settling_kept_per_second = 1e-6f;
// A settling body that trembles above the sleeping speeds, but not by this factor, waits longer instead of
// anew.
constexpr float tremble_factor = 4.0f;
// Bodies that touch sleep together, and in a large heap some light piece between heavy ones always trembles:
// what presses on it is known to a few per cent only. Where this part of the mass is calm and nothing is
// faster than a tremble, the rest counts as calm after this multiple of the sleeping time.
constexpr float calm_part = 0.9f;
constexpr float quiet_factor = 2.0f;
// A body that after this multiple of the sleeping time still is within this part of what the sleeping speeds
// make of the sleeping time (4 cm and 0.4 rad) from where it was rocks in place, however fast.
constexpr float place_factor = 2.0f;
constexpr float place_part = 1.0f;
// Waiting counts up to this multiple of the sleeping time, so that a tremble does not at once wake a body
// that waits for its neighbours.
constexpr float patience = 1.5f;

// What is deeper than this in the ground, in metres, does not fall asleep before it has come up.
constexpr float sunk_depth = 1e-3f;

} // namespace

void SteppedWorld::solveConstraints(btContactSolverInfo& info) {
    for (const auto& body : bodies_) {
        if (body->fixed) continue;
        body->unhindered = body->velocity();
        body->unhindered.linear += body->rigid->getTotalForce() * (body->rigid->getInvMass() * info.m_timeStep);
    }
    btDiscreteDynamicsWorld::solveConstraints(info);
}

void SteppedWorld::integrateTransforms(btScalar seconds) {
    for (const auto& body : bodies_) body->moving_seconds = seconds;
    for (const StepStops::Stop& stop : stops_.find(seconds, *getDispatcher())) {
        stop.body->moving_seconds = stop.seconds;
        lose_fall(*stop.body, seconds - stop.seconds);
    }
    for (const auto& body : bodies_) {
        body->blow_frame = body->rigid->getWorldTransform();
        body->left_seconds = seconds;
        if (body->awake())
            move_on(*body, body->moving_seconds);
        else
            body->unhindered = body->solved = body->velocity();
    }
}

// Who stops for the rest of a step does not fall in it either: else it would get the speed without the way. What rests on
// something has not fallen.
void SteppedWorld::lose_fall(BodyRecord& body, btScalar seconds) {
    btRigidBody& rigid = *body.rigid;
    const btVector3 fallen = rigid.getTotalForce() * (rigid.getInvMass() * seconds);
    const btVector3 before = rigid.getLinearVelocity() - fallen;
    if (before.length2() >= rigid.getLinearVelocity().length2()) return;
    rigid.setLinearVelocity(before);
    body.unhindered.linear -= fallen; // what is taken back has lost it, too
}

void SteppedWorld::move_on(BodyRecord& body, btScalar seconds) {
    btRigidBody& rigid = *body.rigid;
    body.blow_frame = rigid.getWorldTransform();
    body.left_seconds = seconds;
    const Spin spin = free_spin({glm::dquat(to_glm(body.blow_frame.getRotation())),
                                 glm::dvec3(to_glm(rigid.getAngularVelocity()))},
                                body.moments, seconds);
    const btVector3 way = rigid.getLinearVelocity() * seconds;
    rigid.setCenterOfMassTransform(
        btTransform(to_bullet(glm::quat(spin.orientation)), body.blow_frame.getOrigin() + way));
    rigid.setAngularVelocity(to_bullet(glm::vec3(spin.velocity)));
    body.solved = body.velocity();
}

void SteppedWorld::updateActivationState(btScalar seconds) {
    if (!settings_.sleeping) return;
    find_touching();
    for (const auto& body : bodies_) {
        btRigidBody& rigid = *body->rigid;
        if (body->fixed) continue;
        if (rigid.getActivationState() == ISLAND_SLEEPING) {
            rigid.setLinearVelocity({0, 0, 0});
            rigid.setAngularVelocity({0, 0, 0});
            continue;
        }
        const float speed =
            std::max(rigid.getLinearVelocity().length() / (settings_.sleep_linear_speed * bullet_units),
                     rigid.getAngularVelocity().length() / settings_.sleep_angular_speed);
        const bool in_place = rocks_in_place(*body, seconds);
        // One tremble that is soon over does not start the wait anew.
        if (!in_place && (!body->touching || speed > tremble_factor))
            body->still_seconds = 0.0f;
        else
            body->still_seconds =
                std::clamp(body->still_seconds + (in_place || speed < 1.0f ? seconds : -seconds), 0.0f,
                           patience * settings_.sleep_seconds);
    }
    find_quiet(seconds);
    const float kept = std::pow(settling_kept_per_second, seconds);
    for (const auto& body : bodies_) {
        if (!body->awake()) continue;
        btRigidBody& rigid = *body->rigid;
        const float waited = std::max(body->still_seconds, body->quiet_seconds / quiet_factor);
        if (waited > 0.5f * settings_.sleep_seconds) {
            rigid.setLinearVelocity(rigid.getLinearVelocity() * kept);
            rigid.setAngularVelocity(rigid.getAngularVelocity() * kept);
        }
        rigid.setActivationState(waited >= settings_.sleep_seconds && !body->sunk ? WANTS_DEACTIVATION : ACTIVE_TAG);
    }
}

bool SteppedWorld::rocks_in_place(BodyRecord& body, btScalar seconds) {
    const btTransform& now = body.rigid->getWorldTransform();
    const float near = place_part * settings_.sleep_seconds;
    const float moved = (now.getOrigin() - body.rest.getOrigin()).length();
    const float turned = now.getRotation().angleShortestPath(body.rest.getRotation());
    if (moved > near * settings_.sleep_linear_speed * bullet_units
        || turned > near * settings_.sleep_angular_speed) {
        body.rest = now;
        body.rest_seconds = 0.0f;
    }
    if (body.touching) body.rest_seconds += seconds;
    return body.rest_seconds > place_factor * settings_.sleep_seconds;
}

// Counts how long the islands have been quiet, in their bodies, as islands come and go.
void SteppedWorld::find_quiet(btScalar seconds) {
    islands_.assign(static_cast<size_t>(getNumCollisionObjects()), {});
    const auto island_of = [this](const BodyRecord& body) -> Island& {
        return islands_[static_cast<size_t>(body.rigid->getIslandTag())];
    };
    for (const auto& body : bodies_) {
        if (!body->awake()) continue;
        Island& island = island_of(*body);
        island.mass += body->mass;
        if (body->still_seconds >= 0.5f * settings_.sleep_seconds) island.calm_mass += body->mass;
        const float speed = body->rigid->getLinearVelocity().length() / bullet_units;
        island.fast = island.fast || !body->touching || speed > tremble_factor * settings_.sleep_linear_speed;
    }
    for (const auto& body : bodies_) {
        if (!body->awake()) continue;
        const Island& island = island_of(*body);
        const bool quiet = !island.fast && island.calm_mass >= calm_part * island.mass;
        body->quiet_seconds =
            quiet ? std::min(body->quiet_seconds + seconds, patience * quiet_factor * settings_.sleep_seconds)
                  : 0.0f;
    }
}

void SteppedWorld::find_touching() {
    for (const auto& body : bodies_) body->touching = body->sunk = false;
    for (int i = 0; i < getDispatcher()->getNumManifolds(); ++i) {
        const btPersistentManifold* manifold = getDispatcher()->getManifoldByIndexInternal(i);
        if (manifold->getNumContacts() == 0) continue;
        for (const btCollisionObject* object : {manifold->getBody0(), manifold->getBody1()})
            if (object->getUserIndex() >= 0)
                bodies_[static_cast<size_t>(object->getUserIndex())]->touching = true;
        if (manifold->getBody1()->getUserIndex() >= 0) continue;
        // Contacts with the ground have the body first.
        BodyRecord& body = *bodies_[static_cast<size_t>(manifold->getBody0()->getUserIndex())];
        for (int p = 0; p < manifold->getNumContacts(); ++p)
            body.sunk = body.sunk || manifold->getContactPoint(p).getDistance() < -sunk_depth * bullet_units;
    }
}

} // namespace brittle::physics
