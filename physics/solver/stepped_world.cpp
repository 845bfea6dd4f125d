#include "physics/solver/stepped_world.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "physics/solver/fetch.h"
#include "physics/solver/narrow_phase.h"

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
// Who rests has been ready, with nothing fast or restless about, for this long, in seconds: what has lost its support is on
// its way by then, and contacts press as they will go on to.
constexpr float let_go_seconds = 0.1f;
// Waiting counts up to this multiple of the sleeping time, so that a tremble does not at once wake a body
// that waits for its neighbours.
constexpr float patience = 1.5f;

// Boxes reach so far around what they hold, in metres: contacts begin before bodies touch.
constexpr float box_slack = 2e-3f;

// What sweeps over more than this in a step, in metres, is out of all bounds.
constexpr float longest_way = 1e5f;

// Air that brakes by less than this part of gravity is left out: pieces of one cut that fall would not fly as one, and all their
// contacts would have to be looked for.
constexpr float unfelt_part = 0.03f;

// Fewer than this are not worth waking another thread for.
constexpr uint32_t min_bodies = 64, min_manifolds = 128;

// What is deeper than this in the ground, in metres, does not fall asleep before it has come up, or has been where it is for
// this multiple of the sleeping time: a crumb under what is hundreds of times as heavy never comes up.
constexpr float sunk_depth = 1e-3f;
constexpr float sunk_factor = 8.0f;

// Of something that several threads may note.
void note(bool& true_now) {
    std::atomic_ref(true_now).store(true, std::memory_order_relaxed);
}

// For who gives bodies their boxes in turn, at the first one's next: the bodies, their forms and proxies, and the points of their hulls.
[[gnu::always_inline]] inline void fetch_hulls(std::span<BodyRecord* const> bodies) {
    constexpr size_t points_ahead = 2, form_ahead = 4, body_ahead = 6;
    if (bodies.size() > body_ahead) fetch(bodies[body_ahead]);
    if (bodies.size() > form_ahead) {
        fetch(bodies[form_ahead]->form.get());
        fetch(bodies[form_ahead]->rigid->getBroadphaseHandle(), sizeof(SweptProxy));
    }
    if (bodies.size() <= points_ahead || bodies[points_ahead]->compound) return;
    const std::span<const btScalar> points = bodies[points_ahead]->form->shape->groups();
    fetch(points.data(), points.size_bytes());
}

} // namespace

void SteppedWorld::for_each_body(std::span<BodyRecord* const> bodies, const auto& visit) {
    threads_.for_chunks(static_cast<uint32_t>(bodies.size()), min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            if (i + fetched_ahead < end) fetch(bodies[i + fetched_ahead]);
            visit(*bodies[i]);
        }
    });
}

void SteppedWorld::for_each_contact(const auto& visit) {
    const std::vector<AnyManifold>& all = islands_.manifolds();
    threads_.for_chunks(static_cast<uint32_t>(all.size()), min_manifolds, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            if (i + fetched_ahead + 1 < end) all[i + fetched_ahead + 1].fetch_contacts();
            if (i + fetched_ahead < end) all[i + fetched_ahead].fetch_body();
            if (all[i].count > 0) visit(all[i]);
        }
    });
}

void SteppedWorld::put_in(NewBody& body) {
    broadphase_.put_in(std::move(body.proxy));
    if (body.sibling) siblings_.add(*body.record->rigid);
}

std::span<const int> SteppedWorld::take_out(BodyRecord& body) {
    btBroadphaseProxy* const proxy = body.rigid->getBroadphaseHandle();
    SweptPairs& pairs = broadphase_.pairs();
    touched_.clear();
    btManifoldArray manifolds;
    for (const int index : pairs.pairs_of(*proxy)) {
        btBroadphasePair& pair = pairs.getOverlappingPairArrayPtr()[index];
        const btBroadphaseProxy& other = *(pair.m_pProxy0 == proxy ? pair.m_pProxy1 : pair.m_pProxy0);
        manifolds.resize(0);
        if (pair.m_algorithm) pair.m_algorithm->getAllContactManifolds(manifolds);
        if (manifolds.size() > 0)
            touched_.push_back(static_cast<const btCollisionObject*>(other.m_clientObject)->getUserIndex());
        pairs.cleanOverlappingPair(pair, getDispatcher());
    }
    broadphase_.destroyProxy(proxy, getDispatcher());
    body.rigid->setBroadphaseHandle(nullptr);
    return touched_;
}

void SteppedWorld::step(btScalar seconds) {
    stepped_.clear();
    for (const auto& body : bodies_)
        if (body->awake()) stepped_.push_back(body.get());
    find_pairs(seconds);
    siblings_.forget();
    find_islands();
    solve(seconds);
    move_all(seconds);
    if (settings_.sleeping) find_who_settles(seconds);
}

void SteppedWorld::find_pairs(btScalar seconds) {
    const btScalar linear_kept = std::pow(1.0f - settings_.linear_damping, seconds);
    const btScalar angular_kept = std::pow(1.0f - settings_.angular_damping, seconds);
    threads_.for_chunks(static_cast<uint32_t>(stepped_.size()), min_bodies,
                        [&](uint32_t, uint32_t begin, uint32_t end) {
                            for (uint32_t i = begin; i < end; ++i) {
                                fetch_hulls(std::span(stepped_).subspan(i, end - i));
                                BodyRecord& body = *stepped_[i];
                                body.start_step();
                                body.rigid->setLinearVelocity(body.rigid->getLinearVelocity() * linear_kept);
                                body.rigid->setAngularVelocity(body.rigid->getAngularVelocity() * angular_kept);
                                set_box(body, seconds);
                            }
                        });
    btDispatcherInfo& info = getDispatchInfo();
    info.m_timeStep = seconds;
    broadphase_.calculateOverlappingPairs(getDispatcher());
    const std::optional<float>& ground = settings_.ground_height;
    siblings_.check(broadphase_.pairs(), ground ? std::optional(*ground * bullet_units) : std::nullopt);
    // After that, as the air meets each piece of a cut alone: at once they would not fly as one any more.
    const float unfelt = unfelt_part * glm::length(settings_.gravity) * seconds;
    if (settings_.air_density > 0.0f)
        threads_.for_chunks(
            static_cast<uint32_t>(stepped_.size()), min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
                for (uint32_t i = begin; i < end; ++i) {
                    if (i + 2 * fetched_ahead < end) fetch(stepped_[i + 2 * fetched_ahead]);
                    if (i + fetched_ahead < end) fetch(&stepped_[i + fetched_ahead]->form->drag);
                    stepped_[i]->form->drag.brake(*stepped_[i]->rigid, settings_.air_density, seconds, unfelt);
                }
            });
    find_contacts(broadphase_.pairs(), static_cast<btCollisionDispatcher&>(*getDispatcher()), info, threads_);
}

// A body that hardly turns has its box looked for once.
void SteppedWorld::set_box(BodyRecord& body, btScalar seconds) {
    btRigidBody& rigid = *body.rigid;
    const btCollisionShape& shape = *rigid.getCollisionShape();
    btVector3 low, high;
    shape.getAabb(rigid.getWorldTransform(), low, high);
    btScalar around = box_slack * bullet_units;
    const btScalar turning = rigid.getAngularVelocity().length() * seconds;
    if (!body.compound && turning * body.reach < around) {
        const btVector3 way = rigid.getLinearVelocity() * seconds;
        around += turning * body.reach;
        low.setMin(low + way);
        high.setMax(high + way);
    } else {
        btTransform ahead;
        rigid.predictIntegratedTransform(seconds, ahead);
        btVector3 low_ahead, high_ahead;
        shape.getAabb(ahead, low_ahead, high_ahead);
        low.setMin(low_ahead);
        high.setMax(high_ahead);
    }
    const btVector3 slack(around, around, around);
    // A body that went astray, or is nowhere, stays where it last was.
    if ((high - low).length() < longest_way * bullet_units)
        broadphase_.setAabb(rigid.getBroadphaseHandle(), low - slack, high + slack, getDispatcher());
    else
        rigid.setActivationState(DISABLE_SIMULATION);
}

void SteppedWorld::find_islands() {
    islands_.find(bodies_, stepped_, broadphase_, threads_);
    for (BodyRecord* body : islands_.woken()) {
        body->start_step();
        stepped_.push_back(body);
    }
    for (BodyRecord* body : islands_.fallen_asleep()) {
        body->rigid->setLinearVelocity({0, 0, 0});
        body->rigid->setAngularVelocity({0, 0, 0});
        body->blow_frame = body->rigid->getWorldTransform();
        body->unhindered = body->solved = {};
    }
}

void SteppedWorld::find_company() {
    company_.assign(bodies_.size(), {});
    for_each_body(islands_.awake(), [&](const BodyRecord& body) {
        if (is_fast(body) || (rises(body) && waited(body) >= settings_.sleep_seconds))
            note(company_[islands_.of(body)].busy);
    });
    const auto note_contacts = [&](uint32_t body, uint32_t fours, bool pressed) -> Company& {
        Company& company = company_[body];
        std::atomic_ref(company.fours).fetch_add(fours, std::memory_order_relaxed);
        if (pressed) note(company.pressed);
        return company;
    };
    for_each_contact([&](const AnyManifold& manifold) {
        if (const GroundManifold* const ground = manifold.ground) {
            const bool pressed =
                std::ranges::any_of(ground->points(), [](const GroundPoint& p) { return p.kept_impulse() > 0.0f; });
            note_contacts(manifold.a, (ground->count + MANIFOLD_CACHE_SIZE - 1) / MANIFOLD_CACHE_SIZE, pressed);
            return;
        }
        const btPersistentManifold& between = *manifold.between;
        bool pressed = false;
        for (int p = 0; p < between.getNumContacts(); ++p)
            pressed = pressed || between.getContactPoint(p).m_appliedImpulse > 0.0f;
        const auto note_other = [&](uint32_t body, uint32_t other, bool other_moves) {
            Company& company = note_contacts(body, 1, pressed);
            if (!other_moves) return;
            const btRigidBody& touched = *bodies_[other]->rigid;
            if (!is_ready(touched) && speed_of(touched) > 1.0f) note(company.disturbed);
        };
        if (manifold.a_moves) note_other(manifold.a, manifold.b, manifold.b_moves);
        if (manifold.b_moves) note_other(manifold.b, manifold.a, manifold.a_moves);
    });
}

void SteppedWorld::let_rest(BodyRecord& body, btScalar seconds) const {
    const Company& company = company_[static_cast<size_t>(body.rigid->getUserIndex())];
    const bool left = company.fours < body.resting_on;
    const bool alone = company_[islands_.of(body)].busy || company.disturbed || left || !is_ready(*body.rigid);
    // What falls is too fast after its first step, and nothing presses on it.
    const bool carried = body.resting || (company.pressed && speed_of(*body.rigid) <= 1.0f);
    body.unmoved_seconds = alone ? 0.0f : body.unmoved_seconds + seconds;
    const bool rests = body.unmoved_seconds >= let_go_seconds && carried;
    if (!body.resting || !rests) body.resting_on = company.fours;
    body.resting = rests;
    if (!rests) return;
    body.rigid->setLinearVelocity({0, 0, 0});
    body.rigid->setAngularVelocity({0, 0, 0});
}

// Notes the velocities that bodies would have without contacts.
void SteppedWorld::solve(btScalar seconds) {
    const btVector3 fall = getGravity() * seconds;
    if (settings_.sleeping) find_company();
    for_each_body(islands_.awake(), [&](BodyRecord& body) {
        if (settings_.sleeping) let_rest(body, seconds);
        body.unhindered = body.velocity();
        if (!body.resting) body.unhindered.linear += fall;
        body.moving_seconds = seconds;
    });
    solver_.solve(islands_.awake(), islands_.manifolds(), threads_);
}

void SteppedWorld::move_all(btScalar seconds) {
    for (const StepStops::Stop& stop : stops_.find(islands_.awake(), seconds, *getDispatcher())) {
        stop.body->moving_seconds = stop.seconds;
        lose_fall(*stop.body, seconds - stop.seconds);
    }
    for_each_body(islands_.awake(), [this](BodyRecord& body) { move_on(body, body.moving_seconds); });
}

// Who stops for the rest of a step does not fall in it either: else it would get the speed without the way. What rests on
// something has not fallen.
void SteppedWorld::lose_fall(BodyRecord& body, btScalar seconds) {
    const btVector3 fallen = getGravity() * seconds, now = body.rigid->getLinearVelocity(), before = now - fallen;
    if (before.length2() >= now.length2()) return;
    body.rigid->setLinearVelocity(before);
    body.unhindered.linear -= fallen; // what is taken back has lost it, too
}

void SteppedWorld::move_on(BodyRecord& body, btScalar seconds) {
    btRigidBody& rigid = *body.rigid;
    body.blow_frame = rigid.getWorldTransform();
    body.left_seconds = seconds;
    const Spin spin =
        free_spin({glm::dquat(to_glm(body.blow_frame.getRotation())), glm::dvec3(to_glm(rigid.getAngularVelocity()))},
                  body.moments, seconds);
    const btVector3 way = rigid.getLinearVelocity() * seconds;
    rigid.setCenterOfMassTransform(
        btTransform(to_bullet(glm::quat(spin.orientation)), body.blow_frame.getOrigin() + way));
    rigid.setAngularVelocity(to_bullet(glm::vec3(spin.velocity)));
    body.solved = body.velocity();
}

bool SteppedWorld::rises(const BodyRecord& body) const {
    return body.sunk && body.rest_seconds < sunk_factor * settings_.sleep_seconds;
}

float SteppedWorld::waited(const BodyRecord& body) const {
    return std::max(body.still_seconds, body.quiet_seconds / quiet_factor);
}

bool SteppedWorld::is_fast(const BodyRecord& body) const {
    return body.rigid->getLinearVelocity().length() > tremble_factor * settings_.sleep_linear_speed * bullet_units;
}

// In sleeping speeds, which may be 0.
float SteppedWorld::speed_of(const btRigidBody& body) const {
    return std::max(body.getLinearVelocity().length() / (settings_.sleep_linear_speed * bullet_units),
                    body.getAngularVelocity().length() / settings_.sleep_angular_speed);
}

void SteppedWorld::find_who_settles(btScalar seconds) {
    find_touching(seconds);
    for_each_body(islands_.awake(), [&](BodyRecord& body) {
        const Touch& touch = touches_[static_cast<size_t>(body.rigid->getUserIndex())];
        body.touching = touch.any;
        body.sunk = touch.sunk;
        count_still(body, seconds);
    });
    find_calm();
    const float kept = std::pow(settling_kept_per_second, seconds);
    for_each_body(islands_.awake(), [&](BodyRecord& body) {
        count_quiet(body, seconds);
        btRigidBody& rigid = *body.rigid;
        if (waited(body) > 0.5f * settings_.sleep_seconds) {
            rigid.setLinearVelocity(rigid.getLinearVelocity() * kept);
            rigid.setAngularVelocity(rigid.getAngularVelocity() * kept);
        }
        const bool ready = waited(body) >= settings_.sleep_seconds && body.touching && !rises(body);
        rigid.setActivationState(ready ? WANTS_DEACTIVATION : ACTIVE_TAG);
    });
}

void SteppedWorld::count_still(BodyRecord& body, btScalar seconds) {
    const float speed = speed_of(*body.rigid);
    const bool in_place = rocks_in_place(body, seconds);
    // One tremble that is soon over does not start the wait anew.
    if (!in_place && (!body.touching || speed > tremble_factor))
        body.still_seconds = 0.0f;
    else
        body.still_seconds = std::clamp(body.still_seconds + (in_place || speed < 1.0f ? seconds : -seconds), 0.0f,
                                        patience * settings_.sleep_seconds);
}

bool SteppedWorld::rocks_in_place(BodyRecord& body, btScalar seconds) {
    const btTransform& now = body.rigid->getWorldTransform();
    const float near = place_part * settings_.sleep_seconds;
    const float moved = (now.getOrigin() - body.rest.getOrigin()).length();
    const float turned = now.getRotation().angleShortestPath(body.rest.getRotation());
    if (moved > near * settings_.sleep_linear_speed * bullet_units || turned > near * settings_.sleep_angular_speed) {
        body.rest = now;
        body.rest_seconds = 0.0f;
    }
    if (body.touching) body.rest_seconds += seconds;
    return body.rest_seconds > place_factor * settings_.sleep_seconds;
}

void SteppedWorld::find_calm() {
    calm_.assign(bodies_.size(), {});
    for (const BodyRecord* body : islands_.awake()) {
        Calm& island = calm_[islands_.of(*body)];
        island.mass += body->mass;
        if (body->still_seconds >= 0.5f * settings_.sleep_seconds) island.calm_mass += body->mass;
        island.fast = island.fast || is_fast(*body);
    }
}

// How long its island has been quiet is counted in the body, as islands come and go.
void SteppedWorld::count_quiet(BodyRecord& body, btScalar seconds) const {
    const Calm& island = calm_[islands_.of(body)];
    const bool quiet = !island.fast && island.calm_mass >= calm_part * island.mass;
    body.quiet_seconds =
        quiet ? std::min(body.quiet_seconds + seconds, patience * quiet_factor * settings_.sleep_seconds) : 0.0f;
}

void SteppedWorld::find_touching(btScalar seconds) {
    touches_.assign(bodies_.size(), {});
    for_each_contact([&](const AnyManifold& manifold) {
        note(touches_[manifold.a].any);
        if (!manifold.ground) return note(touches_[manifold.b].any);
        const BodyRecord& body = *bodies_[manifold.a];
        // Where it would sleep: after the step, which may have turned a corner down, and the repair of overlap that is due.
        for (const GroundPoint& point : manifold.ground->points()) {
            const btVector3 arm = unpacked(point.position) - body.blow_frame.getOrigin();
            btScalar rise = body.rigid->getVelocityInLocalPoint(arm).y() * seconds;
            if (body.repaired) rise += (body.repair * arm - arm).y();
            if (point.distance + rise < -sunk_depth * bullet_units) note(touches_[manifold.a].sunk);
        }
    });
}

} // namespace brittle::physics
