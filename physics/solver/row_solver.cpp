#include "physics/solver/row_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "physics/solver/float4.h"

namespace brittle::physics {

namespace {

// Points of one pair of bodies that are told apart; a hull has up to twelve on the ground, and more only as a compound.
constexpr uint32_t max_points = 32;
// Of how hard a contact presses.
constexpr float no_limit = std::numeric_limits<float>::max();
// The part of its last impulse from which a contact starts.
constexpr float kept_impulse = 0.85f;
// The part of an overlap that is undone in a step, and by how much less by turning than by moving.
constexpr float undone_part = 0.2f;
constexpr float undone_by_turning = 0.1f;

void put(float* to, const btVector3& from) {
    for (int axis = 0; axis < 3; ++axis) to[axis] = from[axis];
}
btVector3 vector(const float* from) {
    return {from[0], from[1], from[2]};
}
bool never_moves(const btCollisionObject* object) {
    return object->isStaticObject();
}
// Fewer than this are not worth waking another thread for.
constexpr uint32_t min_contacts = 128, min_manifolds = 128, min_bodies = 128, min_groups = 4;
// Contacts of a bundle, likewise: it is a task, and with their friction they are 50 KB.
constexpr uint32_t min_bundle = 256;

} // namespace

void RowSolver::solve(std::span<BodyRecord* const> bodies, std::span<const AnyManifold> manifolds, const Step& step,
                      fracture::Threads& threads) {
    take_bodies(bodies, step, threads);
    order(manifolds, threads);
    make_rows(manifolds, step, threads);
    take_deep();
    solve_rows(step, threads);
    hand_back(bodies, manifolds, step.seconds, threads);
}

// None of the tasks looks at what another one changes; side by side where that is worth it, the longest ones first.
void RowSolver::solve_rows(const Step& step, fracture::Threads& threads) {
    const int sweeps = step.sweeps;
    motions_.assign(movers_.size(), {});
    parting_.assign(movers_.size(), {});
    const bool few = places_.size() + points_of_lone_ < min_contacts;
    const auto parts_of = [&](uint32_t groups) { return few ? 1 : threads.chunks(groups, min_groups); };
    const uint32_t held_groups = held_rows_.lone_groups(), held_parts = parts_of(held_groups);
    const uint32_t lone_groups = lone_.groups(), lone_parts = parts_of(lone_groups);
    const uint32_t bundles = bundles_.count(), in_bundles = 2 * bundles;
    const auto solve_some = [&](uint32_t task) {
        if (task < in_bundles && task % 2 == 0) return sweep(task / 2, sweeps);
        if (task <= in_bundles) return move_apart(deep_[task / 2], sweeps);
        uint32_t part = task - in_bundles - 1;
        if (part < held_parts)
            return held_rows_.settle(held_groups * part / held_parts, held_groups * (part + 1) / held_parts, sweeps,
                                     motions_.data());
        part -= held_parts;
        lone_.solve(lone_groups * part / lone_parts, lone_groups * (part + 1) / lone_parts,
                    {movers_.data(), motions_.data(), parting_.data()}, ground_step(step), sweeps);
    };
    const uint32_t tasks = in_bundles + 1 + held_parts + lone_parts;
    if (few)
        for (uint32_t task = 0; task < tasks; ++task) solve_some(task);
    else
        threads.for_each(tasks, solve_some);
}

void RowSolver::sweep(uint32_t bundle, int count) {
    const size_t begin = begins_[bundle], end = begins_[bundle + 1];
    const std::span<Row> contacts = std::span(contacts_).subspan(begin, end - begin);
    Motion* const motions = motions_.data();
    for (const Row& row : contacts) give(row, row.impulse, motions);
    held_rows_.give(bundle, motions);
    for (int sweep = 0; sweep < count; ++sweep) {
        press(contacts, motions);
        held_rows_.press(bundle, motions);
        rub(begin, end);
        held_rows_.rub(bundle, motions);
    }
}

void RowSolver::take_bodies(std::span<BodyRecord* const> bodies, const Step& step, fracture::Threads& threads) {
    const auto user_index = [](const BodyRecord& body) { return static_cast<size_t>(body.rigid->getUserIndex()); };
    if (!bodies.empty()) indices_.resize(std::max(indices_.size(), user_index(*bodies.back()) + 1));
    movers_.resize(bodies.size());
    lights_.resize(bodies.size());
    threads.for_chunks(static_cast<uint32_t>(bodies.size()), min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            if (i + fetched_ahead < end) fetch(bodies[i + fetched_ahead]);
            const btRigidBody& rigid = *bodies[i]->rigid;
            indices_[user_index(*bodies[i])] = i;
            movers_[i] = bodies[i]->resting ? Mover{.centre = rigid.getCenterOfMassPosition()} : mover_of(rigid, step);
            lights_[i] = movers_[i].light;
        }
    });
}

Mover RowSolver::mover_of(const btRigidBody& rigid, const Step& step) {
    const btMatrix3x3& turning = rigid.getInvInertiaTensorWorld();
    return {.turning = {turning[0], turning[1], turning[2]},
            .centre = rigid.getCenterOfMassPosition(),
            .linear = rigid.getLinearVelocity() + step.gravity * step.seconds,
            .angular = rigid.getAngularVelocity(),
            .light = rigid.getInvMass()};
}

RowSolver::Between RowSolver::between(const AnyManifold& manifold) const {
    return {manifold.a_moves ? indices_[manifold.a] : nobody, manifold.b_moves ? indices_[manifold.b] : nobody,
            manifold.count};
}

// A sort by counting.
void RowSolver::order(std::span<const AnyManifold> manifolds, fracture::Threads& threads) {
    betweens_.resize(manifolds.size());
    threads.for_chunks(static_cast<uint32_t>(manifolds.size()), min_manifolds,
                       [&](uint32_t, uint32_t begin, uint32_t end) {
                           for (uint32_t i = begin; i < end; ++i) betweens_[i] = between(manifolds[i]);
                       });
    bundles_.start(movers_.size());
    for (const Between& two : betweens_)
        if (!two.held() && two.count > 0) bundles_.join(two.mover_a, two.mover_b, two.count);
    bundles_.finish(min_bundle);
    take_lone(manifolds);
    keys_.clear();
    firsts_.clear();
    solved_firsts_.clear();
    starts_.assign((bundles_.count() + 1) * max_points + 1, 0);
    uint32_t place = 0; // among the points of the same two bodies
    uint32_t solved = 0;
    for (size_t m = 0; m < manifolds.size(); ++m) {
        const Between& two = betweens_[m];
        if (m > 0 && (manifolds[m - 1].a != manifolds[m].a || manifolds[m - 1].b != manifolds[m].b)) place = 0;
        firsts_.push_back(static_cast<uint32_t>(keys_.size()));
        solved_firsts_.push_back(solved);
        if (manifolds[m].between) solved += two.count;
        if (two.count == 0) continue;
        const uint32_t first_key = (two.held() ? bundles_.count() : bundles_.of(two.mover_a)) * max_points;
        for (uint32_t i = 0; i < two.count; ++i, ++place) {
            keys_.push_back(first_key + std::min(place, max_points - 1));
            ++starts_[keys_.back() + 1];
        }
    }
    solved_.resize(solved);
    for (size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    begins_.clear();
    for (size_t key = 0; key < starts_.size() - 1; key += max_points) begins_.push_back(starts_[key]);
    held_ = begins_.back();
    places_.resize(keys_.size());
    for (size_t i = 0; i < keys_.size(); ++i) places_[i] = starts_[keys_[i]]++;
    order_held();
}

// They need no places among the others.
void RowSolver::take_lone(std::span<const AnyManifold> manifolds) {
    lone_.clear();
    points_of_lone_ = 0;
    touched_.assign(movers_.size(), 0);
    for (const Between& two : betweens_)
        for (const uint32_t mover : {two.mover_a, two.mover_b})
            if (mover != nobody && two.count > 0) ++touched_[mover];
    for (size_t m = 0; m < manifolds.size(); ++m) {
        Between& two = betweens_[m];
        if (!manifolds[m].ground || two.count == 0 || touched_[two.mover_a] > 1 || lights_[two.mover_a] == 0.0f)
            continue;
        lone_.add(*manifolds[m].ground, two.mover_a);
        points_of_lone_ += std::exchange(two.count, 0);
    }
    lone_.arrange();
}

void RowSolver::order_held() {
    held_movers_.resize(places_.size() - held_);
    for (size_t i = 0; i < betweens_.size(); ++i) {
        const Between& two = betweens_[i];
        if (!two.held()) continue;
        for (uint32_t k = 0; k < two.count; ++k)
            held_movers_[places_[firsts_[i] + k] - held_] = std::min(two.mover_a, two.mover_b); // one is nobody
    }
    held_rows_.arrange(held_movers_, lights_, bundles_);
}

void RowSolver::make_rows(std::span<const AnyManifold> manifolds, const Step& step, fracture::Threads& threads) {
    contacts_.resize(held_);
    frictions_.resize(held_);
    coefficients_.resize(held_);
    depths_.resize(places_.size());
    threads.for_chunks(static_cast<uint32_t>(manifolds.size()), min_manifolds,
                       [&](uint32_t, uint32_t begin, uint32_t end) {
                           for (uint32_t i = begin; i < end; ++i) {
                               if (i + fetched_ahead < end && betweens_[i + fetched_ahead].count > 0)
                                   manifolds[i + fetched_ahead].fetch_contacts();
                               if (betweens_[i].count == 0) continue;
                               if (manifolds[i].ground)
                                   make_rows(*manifolds[i].ground, places_of(i), step);
                               else
                                   make_rows(*manifolds[i].between, places_of(i), solved_of(i), step);
                           }
                       });
}

std::span<const uint32_t> RowSolver::places_of(size_t manifold) const {
    return std::span(places_).subspan(firsts_[manifold], betweens_[manifold].count);
}

std::span<RowSolver::Solved> RowSolver::solved_of(size_t manifold) {
    return std::span(solved_).subspan(solved_firsts_[manifold], betweens_[manifold].count);
}

void RowSolver::make_rows(btPersistentManifold& manifold, std::span<const uint32_t> places, std::span<Solved> solved,
                          const Step& step) {
    // What is deeper than a step may undo counts as that deep.
    const float deepest = step.separation_speed * step.seconds / undone_part;
    const btCollisionObject *a = manifold.getBody0(), *b = manifold.getBody1();
    const bool turned = never_moves(a), held = turned || never_moves(b);
    for (size_t i = 0; i < places.size(); ++i) {
        btManifoldPoint& point = manifold.getContactPoint(static_cast<int>(i));
        const btVector3 &on_a = point.getPositionWorldOnA(), &on_b = point.getPositionWorldOnB();
        const btVector3 position = !held ? 0.5f * (on_a + on_b) : turned ? on_b : on_a;
        const float distance = std::max(point.getDistance(), -deepest);
        const auto turn = [&](const btVector3& v) { return turned ? -v : v; };
        const Made made = make_row({.a = side_of(turned ? b : a, position),
                                    .b = side_of(turned ? a : b, position),
                                    .normal = turn(point.m_normalWorldOnB),
                                    .distance = distance,
                                    .undone_part = undone_part,
                                    .restitution = point.m_combinedRestitution,
                                    .coefficient = point.m_combinedFriction,
                                    .impulse = point.m_appliedImpulse,
                                    .friction = point.m_appliedImpulseLateral1,
                                    .along = turn(point.m_lateralFrictionDir1),
                                    .odd = i % 2 != 0},
                                   places[i], step);
        solved[i] = {.manifold = &manifold,
                     .point = &point,
                     .position = position,
                     .distance = distance,
                     .speed = made.speed,
                     .impulse = 0.0f,
                     .friction = turn(made.along)};
    }
}

GroundStep RowSolver::ground_step(const Step& step) {
    return {.seconds = step.seconds,
            .gravity = step.gravity,
            .min_bounce_speed = step.min_bounce_speed,
            .kept_impulse = kept_impulse};
}

void RowSolver::make_rows(GroundManifold& ground, std::span<const uint32_t> places, const Step& step) {
    const Mover& mover = movers_[indices_[static_cast<size_t>(ground.body->getUserIndex())]];
    if (mover.light == 0.0f) return make_rows_of_resting(ground, places, step);
    for (size_t first = 0; first < places.size(); first += 4) {
        const GroundRows made = ground_rows(mover, ground, first, ground_step(step));
        for (size_t i = first; i < std::min(places.size(), first + 4); ++i) {
            const size_t lane = i - first;
            GroundPoint& point = ground.all[i];
            point.speed = made.speed[lane];
            point.along = {made.frictions.normal[0][lane], made.frictions.normal[1][lane],
                           made.frictions.normal[2][lane]};
            depths_[places[i]] = made.depth[lane];
            held_rows_.put(places[i] - held_, made.contacts, made.frictions, lane, ground.friction);
        }
    }
}

void RowSolver::make_rows_of_resting(GroundManifold& ground, std::span<const uint32_t> places, const Step& step) {
    for (size_t i = 0; i < places.size(); ++i) {
        GroundPoint& point = ground.all[i];
        const Made made = make_row({.a = side_of(ground.body, unpacked(point.position)),
                                    .b = {},
                                    .normal = {0, 1, 0},
                                    .distance = point.distance,
                                    .undone_part = GroundRows::undone_part,
                                    .restitution = ground.restitution,
                                    .coefficient = ground.friction,
                                    .impulse = point.kept_impulse(),
                                    .friction = point.kept_friction(),
                                    .along = unpacked(point.along),
                                    .odd = i % 2 != 0},
                                   places[i], step);
        point.speed = made.speed;
        point.along = packed(made.along);
    }
}

RowSolver::Side RowSolver::side_of(const btCollisionObject* object, const btVector3& position) const {
    if (never_moves(object)) return {nullptr, 0, {0, 0, 0}};
    const uint32_t index = indices_[static_cast<size_t>(object->getUserIndex())];
    return {&movers_[index], index, position - movers_[index].centre};
}

// Of the two bodies a is the one that moves, where one does not.
Row RowSolver::row_along(const btVector3& normal, const Side& a, const Side& b) {
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

inline RowSolver::Made RowSolver::make_row(const Touch& touch, size_t place, const Step& step) {
    const Side &a = touch.a, &b = touch.b;
    const btVector3& normal = touch.normal;
    Row row = row_along(normal, a, b);
    // Between those that rest, or where one does on what never moves: all stays as it is.
    const bool still = row.gain == 0.0f;
    const float apart = still ? 0.0f : -row.wanted / row.gain;
    // Before the step's gravity, which is the same for both where both move.
    const float before = b.mover || still ? apart : apart - normal.dot(step.gravity) * step.seconds;
    const float bounce = std::abs(before) < step.min_bounce_speed ? 0.0f : std::max(0.0f, -before * touch.restitution);
    row.wanted += (bounce - std::max(touch.distance, 0.0f) / step.seconds) * row.gain;
    row.impulse = touch.impulse * (still ? 1.0f : kept_impulse);
    depths_[place] = std::max(-touch.distance, 0.0f) * touch.undone_part / step.seconds * row.gain;

    btVector3 sliding = a.mover->linear + a.mover->angular.cross(a.arm);
    if (b.mover) sliding -= b.mover->linear + b.mover->angular.cross(b.arm);
    sliding -= normal * apart;
    btVector3 along;
    if (still && touch.along.length2() > 0.5f)
        along = touch.along;
    else if (const float square = sliding.length2(); square > SIMD_EPSILON)
        along = sliding / std::sqrt(square);
    else {
        // Points beside each other take turns, so that together they hold both ways.
        btVector3 across;
        btPlaneSpace1(normal, along, across);
        if (touch.odd) along = across;
    }
    Row friction = row_along(along, a, b);
    if (still) friction.impulse = touch.friction;
    if (place >= held_) {
        held_rows_.put(place - held_, row, friction, touch.coefficient);
    } else {
        contacts_[place] = row;
        frictions_[place] = friction;
        coefficients_[place] = touch.coefficient;
    }
    return {.speed = -before, .along = along};
}

void RowSolver::press(std::span<Row> rows, Motion* motions) {
    for (Row& row : rows) resolve(row, motions, 0.0f, no_limit);
}

void RowSolver::rub(size_t begin, size_t end) {
    Motion* const motions = motions_.data();
    for (size_t i = begin; i < end; ++i) {
        const float most = coefficients_[i] * contacts_[i].impulse;
        if (most <= 0.0f && frictions_[i].impulse == 0.0f) continue;
        resolve(frictions_[i], motions, -most, most);
    }
}

inline void RowSolver::push_first(const Row& row, float impulse, Motion* motions) {
    Motion& a = motions[row.a];
    (Float4::load(a.linear) + Float4::load3(row.normal) * Float4::all(impulse * row.light_a)).store(a.linear);
    (Float4::load(a.angular) + Float4::load3(row.turn_a) * Float4::all(impulse)).store(a.angular);
}

void RowSolver::give(const Row& row, float impulse, Motion* motions) {
    push_first(row, impulse, motions);
    Motion& b = motions[row.b];
    (Float4::load(b.linear) - Float4::load3(row.normal) * Float4::all(impulse * row.light_b)).store(b.linear);
    (Float4::load(b.angular) + Float4::load3(row.turn_b) * Float4::all(impulse)).store(b.angular);
}

inline void RowSolver::resolve(Row& row, Motion* motions, float low, float high) {
    const Motion &a = motions[row.a], &b = motions[row.b];
    const float apart =
        sum3(Float4::load3(row.normal) * (Float4::load(a.linear) - Float4::load(b.linear))
             + Float4::load3(row.arm_a) * Float4::load(a.angular) + Float4::load3(row.arm_b) * Float4::load(b.angular));
    const float before = row.impulse;
    row.impulse = std::clamp(before + row.wanted - apart * row.gain, low, high);
    give(row, row.impulse - before, motions);
}

// Where b never moves, it is neither read nor written: all that lie on the ground would wait for each other.
inline void RowSolver::resolve_held(Row& row, Motion* motions) {
    const Motion& a = motions[row.a];
    const float apart =
        sum3(Float4::load3(row.normal) * Float4::load(a.linear) + Float4::load3(row.arm_a) * Float4::load(a.angular));
    const float before = row.impulse;
    row.impulse = std::max(0.0f, before + row.wanted - apart * row.gain);
    push_first(row, row.impulse - before, motions);
}

void RowSolver::take_deep() {
    deep_.resize(std::max<size_t>(deep_.size(), bundles_.count() + 1));
    for (Deep& deep : deep_) {
        deep.between.clear();
        deep.held.clear();
    }
    const auto take = [this](size_t place, Row& row) {
        row.wanted = depths_[place];
        row.impulse = 0.0f;
    };
    const auto deep_of = [this](uint32_t mover) -> Deep& {
        return deep_[std::min(bundles_.of(mover), bundles_.count())];
    };
    for (size_t place = 0; place < held_; ++place)
        if (depths_[place] != 0.0f) take(place, deep_of(contacts_[place].a).between.emplace_back(contacts_[place]));
    for (size_t place = held_; place < depths_.size(); ++place)
        if (depths_[place] != 0.0f)
            take(place, deep_of(held_movers_[place - held_]).held.emplace_back(held_rows_.row(place - held_)));
}

// With velocities of their own that only move the bodies and are then forgotten.
void RowSolver::move_apart(Deep& deep, int sweeps) {
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        press(deep.between, parting_.data());
        for (Row& row : deep.held) resolve_held(row, parting_.data());
    }
}

void RowSolver::hand_back(std::span<BodyRecord* const> bodies, std::span<const AnyManifold> manifolds, float seconds,
                          fracture::Threads& threads) {
    threads.for_chunks(static_cast<uint32_t>(bodies.size()), min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            if (i + fetched_ahead < end) fetch(bodies[i + fetched_ahead]);
            hand_back(*bodies[i], i, seconds);
        }
    });
    threads.for_chunks(static_cast<uint32_t>(manifolds.size()), min_manifolds,
                       [&](uint32_t, uint32_t begin, uint32_t end) {
                           for (uint32_t i = begin; i < end; ++i) {
                               if (i + fetched_ahead < end && betweens_[i + fetched_ahead].count > 0)
                                   manifolds[i + fetched_ahead].fetch_contacts();
                               const std::span<const uint32_t> places = places_of(i);
                               for (size_t k = 0; k < places.size(); ++k)
                                   if (manifolds[i].ground)
                                       hand_back(manifolds[i].ground->all[k], places[k]);
                                   else
                                       hand_back(solved_of(i)[k], places[k]);
                           }
                       });
}

void RowSolver::hand_back(BodyRecord& body, size_t mover, float seconds) const {
    body.rigid->setLinearVelocity(movers_[mover].linear + vector(motions_[mover].linear));
    body.rigid->setAngularVelocity(movers_[mover].angular + vector(motions_[mover].angular));
    const btVector3 way = vector(parting_[mover].linear) * seconds;
    const btVector3 turn = vector(parting_[mover].angular) * (undone_by_turning * seconds);
    const float angle = turn.length();
    body.repaired = angle > 0.0f || way.length2() > 0.0f;
    if (!body.repaired) return;
    body.repair.setOrigin(way);
    body.repair.setRotation(angle > 0.0f ? btQuaternion(turn / angle, angle) : btQuaternion::getIdentity());
}

HeldRows::Impulses RowSolver::impulses(size_t place) const {
    if (place >= held_) return held_rows_.impulses(place - held_);
    return {contacts_[place].impulse, frictions_[place].impulse};
}

void RowSolver::hand_back(Solved& contact, size_t place) const {
    btManifoldPoint& point = *contact.point;
    const auto [pressed, rubbed] = impulses(place);
    point.m_lateralFrictionDir1 = contact.friction;
    contact.impulse = pressed;
    contact.friction = point.m_lateralFrictionDir1 * rubbed;
    const bool blow = contact.speed > blow_speed * bullet_units;
    point.m_appliedImpulse = blow ? 0.0f : contact.impulse;
    point.m_appliedImpulseLateral1 = blow ? 0.0f : rubbed;
}

void RowSolver::hand_back(GroundPoint& contact, size_t place) const {
    const auto [pressed, rubbed] = impulses(place);
    contact.take(pressed, rubbed);
}

} // namespace brittle::physics
