#include "physics/solver/row_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "physics/solver/float4.h"

namespace brittle::physics {

namespace {

// Number of points of one pair that the counting sort of order() tells apart. A hull has up to twelve on the ground, a
// compound more.
constexpr uint32_t max_points = 32;
// Upper bound of a contact's lambda.
constexpr float no_limit = std::numeric_limits<float>::max();
// Warm starting: part of the last impulse from which a contact's lambda starts.
constexpr float warm_start_part = 0.85f;
// Part of an overlap that a step corrects, and the share of the correcting rotation that is applied.
constexpr float correction_part = 0.2f;
constexpr float rotation_share = 0.1f;

// Fewer than this are not worth waking another thread for.
constexpr uint32_t min_contacts = 128, min_manifolds = 128, min_bodies = 128, min_groups = 4;
// Least number of contacts in a bundle: worth a task, and with their friction rows 50 KB.
constexpr uint32_t min_bundle = 256;

void put(float* to, const glm::vec3& from) {
    for (int axis = 0; axis < 3; ++axis) to[axis] = from[axis];
}
glm::vec3 vector(const float* from) {
    return {from[0], from[1], from[2]};
}

} // namespace

void RowSolver::solve(std::span<Body* const> bodies, std::span<const AnyManifold> manifolds, const Step& step,
                      fracture::Threads& threads) {
    take_bodies(bodies, step, threads);
    order(manifolds, threads);
    make_rows(manifolds, step, threads);
    take_deep();
    solve_rows(step, threads);
    store(bodies, manifolds, step.seconds, threads);
}

// Tasks are independent: none reads what another writes. The longest tasks come first.
void RowSolver::solve_rows(const Step& step, fracture::Threads& threads) {
    const int sweeps = step.sweeps;
    changes_.assign(bodies_.size(), {});
    position_changes_.assign(bodies_.size(), {});
    const bool few = places_.size() + points_of_lone_ < min_contacts;
    const auto parts_of = [&](uint32_t groups) { return few ? 1 : threads.chunks(groups, min_groups); };
    const uint32_t static_groups = static_rows_.lone_groups(), static_parts = parts_of(static_groups);
    const uint32_t lone_groups = lone_.groups(), lone_parts = parts_of(lone_groups);
    const uint32_t bundles = bundles_.count(), in_bundles = 2 * bundles;
    const auto solve_some = [&](uint32_t task) {
        if (task < in_bundles && task % 2 == 0) return sweep(task / 2, sweeps);
        if (task <= in_bundles) return correct_overlap(deep_[task / 2], sweeps);
        uint32_t part = task - in_bundles - 1;
        if (part < static_parts)
            return static_rows_.solve_lone(static_groups * part / static_parts,
                                           static_groups * (part + 1) / static_parts, sweeps, changes_.data());
        part -= static_parts;
        lone_.solve(lone_groups * part / lone_parts, lone_groups * (part + 1) / lone_parts,
                    {bodies_.data(), changes_.data(), position_changes_.data()}, ground_step(step), sweeps);
    };
    const uint32_t tasks = in_bundles + 1 + static_parts + lone_parts;
    if (few)
        for (uint32_t task = 0; task < tasks; ++task) solve_some(task);
    else
        threads.for_each(tasks, solve_some);
}

void RowSolver::sweep(uint32_t bundle, int count) {
    const size_t begin = begins_[bundle], end = begins_[bundle + 1];
    const std::span<Row> contacts = std::span(contacts_).subspan(begin, end - begin);
    VelocityChange* const changes = changes_.data();
    for (const Row& row : contacts) apply(row, row.impulse, changes);
    static_rows_.apply(bundle, changes);
    for (int sweep = 0; sweep < count; ++sweep) {
        solve_contacts(contacts, changes);
        static_rows_.solve_contacts(bundle, changes);
        solve_friction(begin, end);
        static_rows_.solve_friction(bundle, changes);
    }
}

void RowSolver::take_bodies(std::span<Body* const> bodies, const Step& step, fracture::Threads& threads) {
    if (!bodies.empty()) indices_.resize(std::max<size_t>(indices_.size(), bodies.back()->index + 1));
    bodies_.resize(bodies.size());
    inverse_masses_.resize(bodies.size());
    threads.for_chunks(static_cast<uint32_t>(bodies.size()), min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            if (i + prefetch_distance < end) prefetch(bodies[i + prefetch_distance]);
            indices_[bodies[i]->index] = i;
            bodies_[i] = solver_body(*bodies[i], step);
            inverse_masses_[i] = bodies_[i].inverse_mass;
        }
    });
}

SolverBody RowSolver::solver_body(const Body& body, const Step& step) {
    if (body.resting) return {.centre = body.frame.origin};
    return {
        .inverse_inertia = {row(body.inverse_inertia, 0), row(body.inverse_inertia, 1), row(body.inverse_inertia, 2)},
        .centre = body.frame.origin,
        .linear = body.velocity.linear + step.gravity * step.seconds,
        .angular = body.velocity.angular,
        .inverse_mass = body.inverse_mass};
}

RowSolver::Sides RowSolver::sides_of(const AnyManifold& manifold) const {
    return {manifold.a_moves ? indices_[manifold.a] : none, manifold.b_moves ? indices_[manifold.b] : none,
            manifold.count};
}

// A counting sort by bundle and index in the manifold.
void RowSolver::order(std::span<const AnyManifold> manifolds, fracture::Threads& threads) {
    sides_.resize(manifolds.size());
    threads.for_chunks(static_cast<uint32_t>(manifolds.size()), min_manifolds,
                       [&](uint32_t, uint32_t begin, uint32_t end) {
                           for (uint32_t i = begin; i < end; ++i) sides_[i] = sides_of(manifolds[i]);
                       });
    bundles_.start(bodies_.size());
    for (const Sides& two : sides_)
        if (!two.one_sided() && two.count > 0) bundles_.join(two.a, two.b, two.count);
    bundles_.finish(min_bundle);
    take_lone(manifolds);
    keys_.clear();
    firsts_.clear();
    solved_firsts_.clear();
    starts_.assign((bundles_.count() + 1) * max_points + 1, 0);
    uint32_t place = 0; // among the points of the same two bodies
    uint32_t solved = 0;
    for (size_t m = 0; m < manifolds.size(); ++m) {
        const Sides& two = sides_[m];
        if (m > 0 && (manifolds[m - 1].a != manifolds[m].a || manifolds[m - 1].b != manifolds[m].b)) place = 0;
        firsts_.push_back(static_cast<uint32_t>(keys_.size()));
        solved_firsts_.push_back(solved);
        if (manifolds[m].between) solved += two.count;
        if (two.count == 0) continue;
        const uint32_t first_key = (two.one_sided() ? bundles_.count() : bundles_.of(two.a)) * max_points;
        for (uint32_t i = 0; i < two.count; ++i, ++place) {
            keys_.push_back(first_key + std::min(place, max_points - 1));
            ++starts_[keys_.back() + 1];
        }
    }
    solved_.resize(solved);
    for (size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    begins_.clear();
    for (size_t key = 0; key < starts_.size() - 1; key += max_points) begins_.push_back(starts_[key]);
    first_static_ = begins_.back();
    places_.resize(keys_.size());
    for (size_t i = 0; i < keys_.size(); ++i) places_[i] = starts_[keys_[i]]++;
    order_static();
}

// Moves bodies that touch the ground only from the ordered points to lone_.
void RowSolver::take_lone(std::span<const AnyManifold> manifolds) {
    lone_.clear();
    points_of_lone_ = 0;
    touched_.assign(bodies_.size(), 0);
    for (const Sides& two : sides_)
        for (const uint32_t body : {two.a, two.b})
            if (body != none && two.count > 0) ++touched_[body];
    for (size_t m = 0; m < manifolds.size(); ++m) {
        Sides& two = sides_[m];
        if (!manifolds[m].ground || two.count == 0 || touched_[two.a] > 1 || inverse_masses_[two.a] == 0.0f) continue;
        lone_.add(*manifolds[m].ground, two.a);
        points_of_lone_ += std::exchange(two.count, 0);
    }
    lone_.arrange();
}

void RowSolver::order_static() {
    static_bodies_.resize(places_.size() - first_static_);
    for (size_t i = 0; i < sides_.size(); ++i) {
        const Sides& two = sides_[i];
        if (!two.one_sided()) continue;
        for (uint32_t k = 0; k < two.count; ++k)
            static_bodies_[places_[firsts_[i] + k] - first_static_] =
                std::min(two.a, two.b); // one of the two is `none`
    }
    static_rows_.arrange(static_bodies_, inverse_masses_, bundles_);
}

void RowSolver::make_rows(std::span<const AnyManifold> manifolds, const Step& step, fracture::Threads& threads) {
    contacts_.resize(first_static_);
    frictions_.resize(first_static_);
    coefficients_.resize(first_static_);
    corrections_.resize(places_.size());
    threads.for_chunks(static_cast<uint32_t>(manifolds.size()), min_manifolds,
                       [&](uint32_t, uint32_t begin, uint32_t end) {
                           for (uint32_t i = begin; i < end; ++i) {
                               if (i + prefetch_distance < end && sides_[i + prefetch_distance].count > 0)
                                   manifolds[i + prefetch_distance].prefetch_contacts();
                               if (sides_[i].count == 0) continue;
                               if (manifolds[i].ground)
                                   make_rows(*manifolds[i].ground, places_of(i), step);
                               else
                                   make_rows(*manifolds[i].between, places_of(i), solved_of(i), step);
                           }
                       });
}

std::span<const uint32_t> RowSolver::places_of(size_t manifold) const {
    return std::span(places_).subspan(firsts_[manifold], sides_[manifold].count);
}

std::span<RowSolver::Solved> RowSolver::solved_of(size_t manifold) {
    return std::span(solved_).subspan(solved_firsts_[manifold], sides_[manifold].count);
}

void RowSolver::make_rows(Manifold& manifold, std::span<const uint32_t> places, std::span<Solved> solved,
                          const Step& step) {
    // The overlap that a step may correct; a deeper one counts as this deep.
    const float deepest = step.separation_speed * step.seconds / correction_part;
    const Body &a = manifold.a(), &b = manifold.b();
    const bool swapped = a.fixed, one_sided = swapped || b.fixed;
    const auto swap = [&](const glm::vec3& v) { return swapped ? -v : v; };
    for (size_t i = 0; i < places.size(); ++i) {
        ContactPoint& point = manifold.points()[i];
        const glm::vec3 position = !one_sided ? 0.5f * (point.on_a + point.on_b) : swapped ? point.on_b : point.on_a;
        const float distance = std::max(point.distance, -deepest);
        const Made made = make_row({.a = side_of(swapped ? b : a, position),
                                    .b = side_of(swapped ? a : b, position),
                                    .normal = swap(point.normal),
                                    .distance = distance,
                                    .correction_part = correction_part,
                                    .restitution = manifold.restitution(),
                                    .coefficient = manifold.friction(),
                                    .normal_impulse = point.normal_impulse,
                                    .friction_impulse = point.friction_impulse,
                                    .tangent = swap(point.tangent),
                                    .odd = i % 2 != 0},
                                   places[i], step);
        solved[i] = {.manifold = &manifold,
                     .point = &point,
                     .position = position,
                     .distance = distance,
                     .speed = made.speed,
                     .impulse = 0.0f,
                     .friction = swap(made.tangent)};
    }
}

GroundStep RowSolver::ground_step(const Step& step) {
    return {.seconds = step.seconds,
            .gravity = step.gravity,
            .min_bounce_speed = step.min_bounce_speed,
            .warm_start_part = warm_start_part};
}

void RowSolver::make_rows(GroundManifold& ground, std::span<const uint32_t> places, const Step& step) {
    const SolverBody& body = bodies_[indices_[ground.body->index]];
    if (body.inverse_mass == 0.0f) return make_rows_of_resting(ground, places, step);
    for (size_t first = 0; first < places.size(); first += 4) {
        const GroundRows made = ground_rows(body, ground, first, ground_step(step));
        for (size_t i = first; i < std::min(places.size(), first + 4); ++i) {
            const size_t lane = i - first;
            GroundPoint& point = ground.all[i];
            const auto& tangent = made.frictions.normal;
            point.speed = made.speed[lane];
            point.tangent = {tangent[0][lane], tangent[1][lane], tangent[2][lane]};
            corrections_[places[i]] = made.correction[lane];
            static_rows_.put(places[i] - first_static_, made.contacts, made.frictions, lane, ground.friction);
        }
    }
}

void RowSolver::make_rows_of_resting(GroundManifold& ground, std::span<const uint32_t> places, const Step& step) {
    for (size_t i = 0; i < places.size(); ++i) {
        GroundPoint& point = ground.all[i];
        const Made made = make_row({.a = side_of(*ground.body, point.position),
                                    .b = {},
                                    .normal = {0, 1, 0},
                                    .distance = point.distance,
                                    .correction_part = GroundRows::correction_part,
                                    .restitution = ground.restitution,
                                    .coefficient = ground.friction,
                                    .normal_impulse = point.warm_normal_impulse(),
                                    .friction_impulse = point.warm_friction_impulse(),
                                    .tangent = point.tangent,
                                    .odd = i % 2 != 0},
                                   places[i], step);
        point.speed = made.speed;
        point.tangent = made.tangent;
    }
}

RowSolver::Side RowSolver::side_of(const Body& body, const glm::vec3& position) const {
    if (body.fixed) return {nullptr, 0, glm::vec3(0.0f)};
    const uint32_t index = indices_[body.index];
    return {&bodies_[index], index, position - bodies_[index].centre};
}

// J and m_eff of row.h along a direction n, and the bias of v_target = 0: -m_eff J v.
Row RowSolver::row_along(const glm::vec3& normal, const Side& a, const Side& b) {
    Row row{};
    const auto inverse_inertia_times = [](const SolverBody& body, const glm::vec3& v) {
        return glm::vec3(glm::dot(body.inverse_inertia[0], v), glm::dot(body.inverse_inertia[1], v),
                         glm::dot(body.inverse_inertia[2], v));
    };
    put(row.normal, normal);
    const glm::vec3 angular_a = glm::cross(a.arm, normal),
                    inverse_inertia_a = inverse_inertia_times(*a.body, angular_a);
    put(row.angular_a, angular_a);
    put(row.inverse_inertia_angular_a, inverse_inertia_a);
    float inverse_effective_mass = a.body->inverse_mass + glm::dot(inverse_inertia_a, angular_a);
    row.a = a.index;
    row.inverse_mass_a = a.body->inverse_mass;
    float apart = glm::dot(normal, a.body->linear) + glm::dot(angular_a, a.body->angular);
    if (b.body) {
        const glm::vec3 angular_b = glm::cross(normal, b.arm),
                        inverse_inertia_b = inverse_inertia_times(*b.body, angular_b);
        put(row.angular_b, angular_b);
        put(row.inverse_inertia_angular_b, inverse_inertia_b);
        inverse_effective_mass += b.body->inverse_mass + glm::dot(inverse_inertia_b, angular_b);
        row.b = b.index;
        row.inverse_mass_b = b.body->inverse_mass;
        apart += glm::dot(angular_b, b.body->angular) - glm::dot(normal, b.body->linear);
    }
    row.effective_mass = inverse_effective_mass > 0.0f ? 1.0f / inverse_effective_mass : 0.0f;
    row.bias = -apart * row.effective_mass;
    return row;
}

// Contact: bias = m_eff (v_target - J v), with v_target = bounce - max(distance, 0) / h as in row.h: the gap may close
// within the step. Friction: v_target = 0. The bias of the split impulse goes to corrections_.
inline RowSolver::Made RowSolver::make_row(const Touch& touch, size_t place, const Step& step) {
    const Side &a = touch.a, &b = touch.b;
    const glm::vec3& normal = touch.normal;
    Row row = row_along(normal, a, b);
    // Between two resting bodies, or a resting and a static one, m_eff is 0 and the impulses stay constant.
    const bool at_rest = row.effective_mass == 0.0f;
    const float apart = at_rest ? 0.0f : -row.bias / row.effective_mass;
    // J v_0: before the step's gravity, which cancels for two moving bodies.
    const float before = b.body || at_rest ? apart : apart - glm::dot(normal, step.gravity) * step.seconds;
    const float bounce = std::abs(before) < step.min_bounce_speed ? 0.0f : std::max(0.0f, -before * touch.restitution);
    row.bias += (bounce - std::max(touch.distance, 0.0f) / step.seconds) * row.effective_mass;
    row.impulse = touch.normal_impulse * (at_rest ? 1.0f : warm_start_part);
    corrections_[place] = std::max(-touch.distance, 0.0f) * touch.correction_part / step.seconds * row.effective_mass;

    glm::vec3 sliding = a.body->linear + glm::cross(a.body->angular, a.arm);
    if (b.body) sliding -= b.body->linear + glm::cross(b.body->angular, b.arm);
    sliding -= normal * apart;
    glm::vec3 tangent;
    if (at_rest && length_squared(touch.tangent) > 0.5f)
        tangent = touch.tangent;
    else if (const float square = length_squared(sliding); square > min_sliding_square)
        tangent = sliding * (1.0f / std::sqrt(square));
    else
        tangent = touch.odd ? tangents_of(normal).second : tangents_of(normal).first;
    Row friction = row_along(tangent, a, b);
    if (at_rest) friction.impulse = touch.friction_impulse;
    if (place >= first_static_) {
        static_rows_.put(place - first_static_, row, friction, touch.coefficient);
    } else {
        contacts_[place] = row;
        frictions_[place] = friction;
        coefficients_[place] = touch.coefficient;
    }
    return {.speed = -before, .tangent = tangent};
}

void RowSolver::solve_contacts(std::span<Row> rows, VelocityChange* changes) {
    for (Row& row : rows) solve_row(row, changes, 0.0f, no_limit);
}

// |lambda| <= mu lambda_contact.
void RowSolver::solve_friction(size_t begin, size_t end) {
    VelocityChange* const changes = changes_.data();
    for (size_t i = begin; i < end; ++i) {
        const float most = coefficients_[i] * contacts_[i].impulse;
        if (most <= 0.0f && frictions_[i].impulse == 0.0f) continue;
        solve_row(frictions_[i], changes, -most, most);
    }
}

inline void RowSolver::apply_first(const Row& row, float impulse, VelocityChange* changes) {
    VelocityChange& a = changes[row.a];
    (Float4::load(a.linear) + Float4::load3(row.normal) * Float4::all(impulse * row.inverse_mass_a)).store(a.linear);
    (Float4::load(a.angular) + Float4::load3(row.inverse_inertia_angular_a) * Float4::all(impulse)).store(a.angular);
}

void RowSolver::apply(const Row& row, float impulse, VelocityChange* changes) {
    apply_first(row, impulse, changes);
    VelocityChange& b = changes[row.b];
    (Float4::load(b.linear) - Float4::load3(row.normal) * Float4::all(impulse * row.inverse_mass_b)).store(b.linear);
    (Float4::load(b.angular) + Float4::load3(row.inverse_inertia_angular_b) * Float4::all(impulse)).store(b.angular);
}

inline void RowSolver::solve_row(Row& row, VelocityChange* changes, float low, float high) {
    const VelocityChange &a = changes[row.a], &b = changes[row.b];
    const float apart = sum3(Float4::load3(row.normal) * (Float4::load(a.linear) - Float4::load(b.linear))
                             + Float4::load3(row.angular_a) * Float4::load(a.angular)
                             + Float4::load3(row.angular_b) * Float4::load(b.angular));
    const float before = row.impulse;
    row.impulse = std::clamp(before + row.bias - apart * row.effective_mass, low, high);
    apply(row, row.impulse - before, changes);
}

// Neither reads nor writes a static b: otherwise the rows of all bodies on the ground would depend on each other.
inline void RowSolver::solve_one_sided(Row& row, VelocityChange* changes) {
    const VelocityChange& a = changes[row.a];
    const float apart = sum3(Float4::load3(row.normal) * Float4::load(a.linear)
                             + Float4::load3(row.angular_a) * Float4::load(a.angular));
    const float before = row.impulse;
    row.impulse = std::max(0.0f, before + row.bias - apart * row.effective_mass);
    apply_first(row, row.impulse - before, changes);
}

void RowSolver::take_deep() {
    deep_.resize(std::max<size_t>(deep_.size(), bundles_.count() + 1));
    for (Deep& deep : deep_) {
        deep.between.clear();
        deep.one_sided.clear();
    }
    const auto take = [this](size_t place, Row& row) {
        row.bias = corrections_[place];
        row.impulse = 0.0f;
    };
    const auto deep_of = [this](uint32_t body) -> Deep& {
        return deep_[std::min(bundles_.of(body), bundles_.count())];
    };
    for (size_t place = 0; place < first_static_; ++place)
        if (corrections_[place] != 0.0f)
            take(place, deep_of(contacts_[place].a).between.emplace_back(contacts_[place]));
    for (size_t place = first_static_; place < corrections_.size(); ++place)
        if (corrections_[place] != 0.0f)
            take(place, deep_of(static_bodies_[place - first_static_])
                            .one_sided.emplace_back(static_rows_.row(place - first_static_)));
}

// Split impulses: their dv moves the bodies once and is then discarded.
void RowSolver::correct_overlap(Deep& deep, int sweeps) {
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        solve_contacts(deep.between, position_changes_.data());
        for (Row& row : deep.one_sided) solve_one_sided(row, position_changes_.data());
    }
}

void RowSolver::store(std::span<Body* const> bodies, std::span<const AnyManifold> manifolds, float seconds,
                      fracture::Threads& threads) {
    threads.for_chunks(static_cast<uint32_t>(bodies.size()), min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            if (i + prefetch_distance < end) prefetch(bodies[i + prefetch_distance]);
            store(*bodies[i], i, seconds);
        }
    });
    threads.for_chunks(static_cast<uint32_t>(manifolds.size()), min_manifolds,
                       [&](uint32_t, uint32_t begin, uint32_t end) {
                           for (uint32_t i = begin; i < end; ++i) {
                               if (i + prefetch_distance < end && sides_[i + prefetch_distance].count > 0)
                                   manifolds[i + prefetch_distance].prefetch_contacts();
                               const std::span<const uint32_t> places = places_of(i);
                               for (size_t k = 0; k < places.size(); ++k)
                                   if (manifolds[i].ground)
                                       store(manifolds[i].ground->all[k], places[k]);
                                   else
                                       store(solved_of(i)[k], places[k]);
                           }
                       });
}

void RowSolver::store(Body& body, size_t index, float seconds) const {
    body.velocity.linear = bodies_[index].linear + vector(changes_[index].linear);
    body.velocity.angular = bodies_[index].angular + vector(changes_[index].angular);
    const glm::vec3 translation = vector(position_changes_[index].linear) * seconds;
    const glm::vec3 rotation = vector(position_changes_[index].angular) * (rotation_share * seconds);
    const float angle = glm::length(rotation);
    body.has_correction = angle > 0.0f || length_squared(translation) > 0.0f;
    if (!body.has_correction) return;
    body.correction.origin = translation;
    body.correction.basis = glm::mat3(1.0f);
    if (angle > 0.0f) {
        const glm::vec3 axis = rotation * (1.0f / angle);
        const float s = std::sin(angle * 0.5f) / glm::length(axis);
        body.correction.basis = matrix_of({std::cos(angle * 0.5f), axis.x * s, axis.y * s, axis.z * s});
    }
}

StaticRows::Impulses RowSolver::impulses(size_t place) const {
    if (place >= first_static_) return static_rows_.impulses(place - first_static_);
    return {contacts_[place].impulse, frictions_[place].impulse};
}

void RowSolver::store(Solved& contact, size_t place) const {
    ContactPoint& point = *contact.point;
    const auto [normal, friction] = impulses(place);
    point.tangent = contact.friction;
    contact.impulse = normal;
    contact.friction = point.tangent * friction;
    const bool blow = contact.speed > blow_speed;
    point.normal_impulse = blow ? 0.0f : normal;
    point.friction_impulse = blow ? 0.0f : friction;
}

void RowSolver::store(GroundPoint& contact, size_t place) const {
    const auto [normal, friction] = impulses(place);
    contact.take(normal, friction);
}

} // namespace brittle::physics
