#include "physics/solver/row_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace brittle::physics {

namespace {

// Number of points of one pair that the counting sort of order() tells apart. A hull has up to twelve on the ground, a
// compound more.
constexpr uint32_t max_points = 32;

// Fewer than this are not worth waking another thread for.
constexpr uint32_t min_contacts = 128, min_manifolds = 128, min_bodies = 128, min_groups = 4;
// Least number of contacts in a bundle: worth a task, and with their friction rows 50 KB.
constexpr uint32_t min_bundle = 256;

void put(float* to, const glm::vec3& from) {
    for (int axis = 0; axis < 3; ++axis) to[axis] = from[axis];
}

} // namespace

void RowSolver::solve(std::span<Body* const> bodies, std::span<const AnyManifold> manifolds, Joints& joints,
                      const Step& step, fracture::Threads& threads) {
    joints_ = &joints;
    take_bodies(bodies, threads);
    order(manifolds, threads);
    make_rows(manifolds, step, threads);
    joints.make(bundles_, indices_);
    solve_rows(step, threads);
    store(bodies, manifolds, step, threads);
    joints.store();
}

// Tasks are independent: none reads what another writes. The longest tasks come first.
void RowSolver::solve_rows(const Step& step, fracture::Threads& threads) {
    const Substeps& substeps = step.substeps;
    changes_.assign(bodies_.size(), {});
    moved_.assign(bodies_.size(), {});
    free_changes_.resize(bodies_.size());
    added_.resize(bodies_.size());
    descents_.resize(bodies_.size());
    jointed_.assign(bodies_.size(), 0);
    joints_->mark_jointed(jointed_, indices_);
    acted_ = jointed_;
    const bool few = places_.size() + points_of_lone_ < min_contacts;
    const auto parts_of = [&](uint32_t groups) { return few ? 1 : threads.chunks(groups, min_groups); };
    const uint32_t static_groups = static_rows_.lone_groups(), static_parts = parts_of(static_groups);
    const uint32_t lone_groups = lone_.groups(), lone_parts = parts_of(lone_groups);
    const uint32_t bundles = bundles_.count();
    const StaticRows::State state{bodies_.data(), changes_.data(), moved_.data(), acted_.data()};
    const auto solve_some = [&](uint32_t task) {
        if (task < bundles) return solve_bundle(task, substeps);
        uint32_t part = task - bundles;
        if (part < static_parts)
            return static_rows_.solve_lone(static_groups * part / static_parts,
                                           static_groups * (part + 1) / static_parts, substeps, state);
        part -= static_parts;
        lone_.solve(lone_groups * part / lone_parts, lone_groups * (part + 1) / lone_parts, state, ground_step(step),
                    substeps);
    };
    const uint32_t tasks = bundles + static_parts + lone_parts;
    if (few)
        for (uint32_t task = 0; task < tasks; ++task) solve_some(task);
    else
        threads.for_each(tasks, solve_some);
}

void RowSolver::take_bodies(std::span<Body* const> bodies, fracture::Threads& threads) {
    if (!bodies.empty()) indices_.resize(std::max<size_t>(indices_.size(), bodies.back()->index + 1));
    bodies_.resize(bodies.size());
    inverse_masses_.resize(bodies.size());
    threads.for_chunks(static_cast<uint32_t>(bodies.size()), min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            if (i + prefetch_distance < end) prefetch(bodies[i + prefetch_distance]);
            indices_[bodies[i]->index] = i;
            bodies_[i] = solver_body(*bodies[i]);
            inverse_masses_[i] = bodies_[i].inverse_mass;
        }
    });
}

SolverBody RowSolver::solver_body(const Body& body) {
    if (body.resting) return {.centre = body.frame.origin};
    const glm::mat3& axes = body.frame.basis;
    const glm::vec3 moments(body.moments);
    const glm::mat3 inertia =
        glm::mat3(axes[0] * moments.x, axes[1] * moments.y, axes[2] * moments.z) * glm::transpose(axes);
    return {
        .inverse_inertia = {row(body.inverse_inertia, 0), row(body.inverse_inertia, 1), row(body.inverse_inertia, 2)},
        .centre = body.frame.origin,
        .linear = body.velocity.linear,
        .angular = body.velocity.angular,
        .inverse_mass = body.inverse_mass,
        .inertia = {row(inertia, 0), row(inertia, 1), row(inertia, 2)},
        .mass = body.mass};
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
    share_points();
    bundles_.start(bodies_.size());
    for (const Sides& two : sides_)
        if (!two.one_sided() && two.count > 0) bundles_.join(two.a, two.b, two.count);
    joints_->join(bundles_, indices_);
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
    list_bodies();
}

// A counting sort of the solver bodies by bundle; and which bodies have rows.
void RowSolver::list_bodies() {
    bundle_begins_.assign(bundles_.count() + 1, 0);
    for (uint32_t body = 0; body < bodies_.size(); ++body)
        if (bundles_.of(body) != Bundles::none) ++bundle_begins_[bundles_.of(body) + 1];
    for (size_t i = 1; i < bundle_begins_.size(); ++i) bundle_begins_[i] += bundle_begins_[i - 1];
    bundle_bodies_.resize(bundle_begins_.back());
    starts_.assign(bundle_begins_.begin(), bundle_begins_.end());
    for (uint32_t body = 0; body < bodies_.size(); ++body)
        if (bundles_.of(body) != Bundles::none) bundle_bodies_[starts_[bundles_.of(body)]++] = body;
}

void RowSolver::share_points() {
    points_.assign(bodies_.size(), 0);
    for (const Sides& two : sides_)
        for (const uint32_t body : {two.a, two.b})
            if (body != none) points_[body] += two.count;
    for (size_t body = 0; body < bodies_.size(); ++body)
        if (points_[body] > 0) bodies_[body].share = 1.0f / static_cast<float>(points_[body]);
}

// Moves bodies that touch the ground only from the ordered points to lone_.
void RowSolver::take_lone(std::span<const AnyManifold> manifolds) {
    lone_.clear();
    points_of_lone_ = 0;
    touched_.assign(bodies_.size(), 0);
    for (const Sides& two : sides_)
        for (const uint32_t body : {two.a, two.b})
            if (body != none && two.count > 0) ++touched_[body];
    joints_->touch(touched_, indices_);
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
    const Body &a = manifold.a(), &b = manifold.b();
    // A deeper overlap counts as one that is corrected at the separation speed.
    const float deepest = step.separation_speed * step.substeps.seconds / step.substeps.push_part + manifold.slop();
    const bool swapped = a.fixed, one_sided = swapped || b.fixed;
    const auto swap = [&](const glm::vec3& v) { return swapped ? -v : v; };
    for (size_t i = 0; i < places.size(); ++i) {
        ContactPoint& point = manifold.points()[i];
        const glm::vec3 position = !one_sided ? 0.5f * (point.on_a + point.on_b) : swapped ? point.on_b : point.on_a;
        const float distance = std::max(point.distance, -deepest);
        const float speed = make_row({.a = side_of(swapped ? b : a, position),
                                      .b = side_of(swapped ? a : b, position),
                                      .normal = swap(point.normal),
                                      .distance = distance,
                                      .slop = manifold.slop(),
                                      .restitution = manifold.restitution(),
                                      .coefficient = manifold.friction(),
                                      .start = {point.start.normal, swap(point.start.friction)}},
                                     places[i], step);
        solved[i] = {.manifold = &manifold,
                     .point = &point,
                     .position = position,
                     .distance = distance,
                     .speed = speed,
                     .impulse = 0.0f,
                     .friction = glm::vec3(0.0f)};
    }
}

GroundStep RowSolver::ground_step(const Step& step) {
    return {.min_bounce_speed = step.min_bounce_speed};
}

void RowSolver::make_rows(GroundManifold& ground, std::span<const uint32_t> places, const Step& step) {
    const SolverBody& body = bodies_[indices_[ground.body->index]];
    if (body.inverse_mass == 0.0f) return make_rows_of_resting(ground, places, step);
    for (size_t first = 0; first < places.size(); first += 4) {
        const GroundRows made = ground_rows(body, ground, first, ground_step(step));
        for (size_t i = first; i < std::min(places.size(), first + 4); ++i) {
            const size_t lane = i - first;
            GroundPoint& point = ground.all[i];
            point.speed = made.speed[lane];
            static_rows_.put(places[i] - first_static_, made.contacts, made.frictions, lane, ground.friction);
        }
    }
}

void RowSolver::make_rows_of_resting(GroundManifold& ground, std::span<const uint32_t> places, const Step& step) {
    for (size_t i = 0; i < places.size(); ++i) {
        GroundPoint& point = ground.all[i];
        point.speed = make_row({.a = side_of(*ground.body, point.position),
                                .b = {},
                                .normal = {0, 1, 0},
                                .distance = point.distance,
                                .slop = ground.slop,
                                .restitution = ground.restitution,
                                .coefficient = ground.friction,
                                .start = point.start},
                               places[i], step);
    }
}

RowSolver::Side RowSolver::side_of(const Body& body, const glm::vec3& position) const {
    if (body.fixed) return {nullptr, 0, glm::vec3(0.0f)};
    const uint32_t index = indices_[body.index];
    return {&bodies_[index], index, position - bodies_[index].centre};
}

// J and m_eff of row.h along a direction n, and -m_eff J v.
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
    row.rest = -apart * row.effective_mass;
    return row;
}

inline float RowSolver::make_row(const Touch& touch, size_t place, const Step& step) {
    const Side &a = touch.a, &b = touch.b;
    const glm::vec3& normal = touch.normal;
    Row row = row_along(normal, a, b);
    // Between two resting bodies, or a resting and a static one, m_eff is 0 and the impulses stay constant.
    const bool at_rest = row.effective_mass == 0.0f;
    const float approach = at_rest ? 0.0f : row.rest / row.effective_mass;
    const float bounce =
        std::abs(approach) < step.min_bounce_speed ? 0.0f : std::max(0.0f, approach * touch.restitution);
    row.gap = touch.distance;
    row.slop = touch.slop;
    row.share = b.body ? std::min(a.body->share, b.body->share) : a.body->share;
    row.bounce = bounce * row.effective_mass;
    row.impulse = row.start = touch.start.normal;
    const FrictionRows friction = friction_of(touch);
    if (place >= first_static_) {
        static_rows_.put(place - first_static_, row, friction, touch.coefficient);
    } else {
        contacts_[place] = row;
        frictions_[place] = friction;
        coefficients_[place] = touch.coefficient;
    }
    return approach;
}

FrictionRows RowSolver::friction_of(const Touch& touch) {
    const Tangents tangents = tangents_of(touch.normal);
    const Row along[2] = {row_along(tangents.first, touch.a, touch.b), row_along(tangents.second, touch.a, touch.b)};
    FrictionRows friction{};
    float response[2];
    for (size_t i = 0; i < 2; ++i) {
        const Row& row = along[i];
        FrictionRows::Along& to = friction.along[i];
        std::ranges::copy(row.normal, to.tangent);
        std::ranges::copy(row.angular_a, to.angular_a);
        std::ranges::copy(row.angular_b, to.angular_b);
        std::ranges::copy(row.inverse_inertia_angular_a, to.inverse_inertia_angular_a);
        std::ranges::copy(row.inverse_inertia_angular_b, to.inverse_inertia_angular_b);
        const bool at_rest = row.effective_mass == 0.0f;
        response[i] = at_rest ? 0.0f : 1.0f / row.effective_mass;
        to.rest = row.rest * response[i];
        friction.impulse[i] = glm::dot(i == 0 ? tangents.first : tangents.second, touch.start.friction);
    }
    const float between = glm::dot(vec3_of(along[0].inverse_inertia_angular_a), vec3_of(along[1].angular_a))
                          + glm::dot(vec3_of(along[0].inverse_inertia_angular_b), vec3_of(along[1].angular_b));
    const float determinant = response[0] * response[1] - between * between;
    const float part = determinant > 0.0f ? 1.0f / determinant : 0.0f;
    friction.mass_11 = response[1] * part;
    friction.mass_12 = -between * part;
    friction.mass_22 = response[0] * part;
    const float trace = response[0] + response[1];
    friction.sliding_mass = trace > 0.0f ? 1.0f / trace : 0.0f;
    friction.inverse_mass_a = along[0].inverse_mass_a;
    friction.inverse_mass_b = along[0].inverse_mass_b;
    friction.a = along[0].a;
    friction.b = along[0].b;
    return friction;
}

void RowSolver::store(std::span<Body* const> bodies, std::span<const AnyManifold> manifolds, const Step& step,
                      fracture::Threads& threads) {
    threads.for_chunks(static_cast<uint32_t>(bodies.size()), min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            if (i + prefetch_distance < end) prefetch(bodies[i + prefetch_distance]);
            store(*bodies[i], i, step);
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

void RowSolver::store(Body& body, size_t index, const Step& step) const {
    const Velocity before{bodies_[index].linear, bodies_[index].angular};
    if (body.resting) {
        body.velocity = body.motion = before;
        return;
    }
    if (acted_[index] == 0) { // falls along its parabola: at the mean of its speeds before and after the step
        const glm::vec3 fall = step.substeps.gravity * step.seconds;
        body.velocity = {before.linear + fall, before.angular};
        body.motion = {before.linear + 0.5f * fall, before.angular};
        return;
    }
    body.velocity = {before.linear + vec3_of(changes_[index].linear),
                     before.angular + vec3_of(changes_[index].angular)};
    const float rate = 1.0f / step.seconds;
    body.motion = {vec3_of(moved_[index].linear) * rate, vec3_of(moved_[index].angular) * rate};
}

StaticRows::Impulses RowSolver::impulses(size_t place) const {
    if (place >= first_static_) return static_rows_.impulses(place - first_static_);
    const Row& row = contacts_[place];
    const FrictionRows& friction = frictions_[place];
    return {.total = row.total,
            .start = row.impulse,
            .friction_total = {friction.total[0], friction.total[1]},
            .friction_start = {friction.impulse[0], friction.impulse[1]}};
}

glm::vec3 RowSolver::friction_along(const Tangents& tangents, const std::array<float, 2>& impulse) {
    return tangents.first * impulse[0] + tangents.second * impulse[1];
}

void RowSolver::store(Solved& contact, size_t place) const {
    ContactPoint& point = *contact.point;
    const StaticRows::Impulses impulse = impulses(place);
    const bool swapped = contact.manifold->a().fixed;
    const Tangents tangents = tangents_of(swapped ? -point.normal : point.normal);
    const auto on_first = [&](const std::array<float, 2>& friction) {
        const glm::vec3 sum = friction_along(tangents, friction);
        return swapped ? -sum : sum;
    };
    point.last = {impulse.total, on_first(impulse.friction_total)};
    point.start = {impulse.start, on_first(impulse.friction_start)};
    contact.impulse = point.last.normal;
    contact.friction = point.last.friction;
}

void RowSolver::store(GroundPoint& contact, size_t place) const {
    const StaticRows::Impulses impulse = impulses(place);
    const auto of = [](float normal, const std::array<float, 2>& friction) {
        return PointImpulse{normal, friction_along(tangents_of_ground(), friction)};
    };
    contact.last = of(impulse.total, impulse.friction_total);
    contact.start = of(impulse.start, impulse.friction_start);
}

} // namespace brittle::physics
