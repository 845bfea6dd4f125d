#include "physics/solver/debris_solver.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "fracture/base/union_find.h"

namespace brittle::physics {

namespace {

// Slabs have at least this many bodies, so that their contacts of one colour fill lanes.
constexpr uint32_t min_slab_bodies = 96;
// Buckets of the histogram that slabs are cut from.
constexpr uint32_t buckets = 1024;
// Keys of a slab: the colours of contacts between moving bodies; contacts that no colour is left for, which have a
// group each; the colours of contacts with static bodies.
constexpr uint32_t pair_colours = 64, uncoloured = pair_colours, static_key = uncoloured + 1,
                   keys_of_slab = static_key + pair_colours;
// Kinds of colours that a body has in use: as the lower or the upper slab of a contact, far, static.
constexpr size_t colour_kinds = 4, far_colours = 2, static_colours = 3;
// Sweeps with which bodies leave the step. With one, a crumb between two heavy bodies keeps what the first of its
// contacts gave it.
constexpr int bounce_sweeps = 6;
// Fewer than this are not worth waking another thread for.
constexpr uint32_t min_groups = 64, min_bodies = 128, min_manifolds = 128;

void put(std::array<Four, 3>& to, size_t lane, const glm::vec3& v) {
    for (int axis = 0; axis < 3; ++axis) to[static_cast<size_t>(axis)][lane] = v[axis];
}
glm::vec3 get(const std::array<Four, 3>& from, size_t lane) {
    return {from[0][lane], from[1][lane], from[2][lane]};
}

// N m s, in world axes.
glm::vec3 momentum_of(const Body& body, const glm::vec3& angular) {
    return body.frame.basis * (glm::vec3(body.moments) * (angular * body.frame.basis));
}

Velocity change_by(const Body& body, const glm::vec3& position, const glm::vec3& impulse, const glm::vec3& torque) {
    const glm::vec3 arm = position - body.frame.origin;
    return {impulse * body.inverse_mass, body.inverse_inertia * (glm::cross(arm, impulse) + torque)};
}

// The larger eigenvalue of a symmetric 2 x 2 matrix.
float largest_eigenvalue(float a, float b, float d) {
    const float half = 0.5f * (a - d);
    return 0.5f * (a + d) + std::sqrt(half * half + b * b);
}

// An upper bound of the eigenvalues of a symmetric matrix.
float bound_of(const glm::mat3& m) {
    float most = 0.0f;
    for (int i = 0; i < 3; ++i) most = std::max(most, std::abs(m[i].x) + std::abs(m[i].y) + std::abs(m[i].z));
    return most;
}

} // namespace

void DebrisSolver::choose(std::span<Body* const> awake, std::span<const AnyManifold> manifolds) {
    const size_t count = awake.empty() ? 0 : awake.back()->index + 1u;
    is_member_.assign(count, 0);
    std::vector<Body*> by_index(count, nullptr);
    for (Body* body : awake) by_index[body->index] = body;
    const auto joins = [&](uint32_t index) { return index < count && by_index[index] && by_index[index]->joints == 0; };
    const auto joins_pair = [&](const AnyManifold& manifold) {
        return manifold.count > 0 && manifold.a_moves && manifold.b_moves && joins(manifold.a) && joins(manifold.b);
    };
    std::vector<uint32_t> parents(count);
    std::iota(parents.begin(), parents.end(), 0u);
    for (const AnyManifold& manifold : manifolds)
        if (joins_pair(manifold)) fracture::unite(parents, manifold.a, manifold.b);
    std::vector<uint8_t> has_debris(count, 0);
    for (const AnyManifold& manifold : manifolds)
        if (manifold.count > 0 && manifold.a_moves && manifold.b_moves)
            for (const uint32_t index : {manifold.a, manifold.b})
                if (joins(index) && by_index[index]->debris) has_debris[fracture::root_of(parents, index)] = 1;
    for (const Body* body : awake)
        if (joins(body->index)) is_member_[body->index] = has_debris[fracture::root_of(parents, body->index)];
    const auto is_member = [&](uint32_t index) { return index < count && is_member_[index] != 0; };
    manifolds_.clear();
    other_manifolds_.clear();
    bodies_.clear();
    other_bodies_.clear();
    std::vector<uint8_t> taken(is_member_.begin(), is_member_.end());
    for (const AnyManifold& manifold : manifolds) {
        const bool own = manifold.ellipsoids || is_member(manifold.a) || is_member(manifold.b);
        (own ? manifolds_ : other_manifolds_).push_back(manifold);
        if (!own || manifold.count == 0) continue;
        if (manifold.a_moves) taken[manifold.a] = 1;
        if (manifold.b_moves) taken[manifold.b] = 1;
    }
    for (Body* body : awake) {
        if (taken[body->index] != 0) bodies_.push_back(body);
        if (is_member_[body->index] == 0) other_bodies_.push_back(body);
    }
    list_bodies();
}

void DebrisSolver::list_bodies() {
    sort_into_slabs();
    guests_.clear();
    is_guest_.assign(bodies_.size(), 0);
    local_.resize(std::max(local_.size(), is_member_.size()));
    for (uint32_t i = 0; i < bodies_.size(); ++i) {
        local_[bodies_[i]->index] = i;
        is_guest_[i] = is_member_[bodies_[i]->index] == 0;
        if (is_guest_[i] != 0) guests_.push_back({.body = i, .before = bodies_[i]->velocity});
    }
}

// A slab is at least as wide as two members that touch.
void DebrisSolver::sort_into_slabs() {
    slabs_.assign(bodies_.size(), 0);
    slab_count_ = 2;
    if (bodies_.empty()) return;
    Bounds around{glm::vec3(unbounded), glm::vec3(-unbounded)};
    float widest_member = 0.0f;
    for (const Body* body : bodies_) {
        around.low = glm::min(around.low, body->frame.origin);
        around.high = glm::max(around.high, body->frame.origin);
        if (is_member_[body->index] != 0) widest_member = std::max(widest_member, 2.0f * body->reach);
    }
    const glm::vec3 extent = around.high - around.low;
    const int axis = extent.x >= extent.z ? (extent.x >= extent.y ? 0 : 1) : (extent.z >= extent.y ? 2 : 1);
    const float width = extent[axis] / static_cast<float>(buckets);
    const auto bucket_of = [&](const Body& body) {
        const float place = width > 0.0f ? (body.frame.origin[axis] - around.low[axis]) / width : 0.0f;
        return std::min(static_cast<uint32_t>(place), buckets - 1);
    };
    starts_.assign(buckets + 1, 0);
    for (const Body* body : bodies_) ++starts_[bucket_of(*body) + 1];
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    std::vector<uint32_t> slab_of(buckets, 0);
    uint32_t slab = 0, first = 0;
    for (uint32_t bucket = 0; bucket < buckets; ++bucket) {
        const bool wide = static_cast<float>(bucket - first) * width >= widest_member;
        if (wide && starts_[bucket] - starts_[first] >= min_slab_bodies) {
            ++slab;
            first = bucket;
        }
        slab_of[bucket] = slab;
    }
    slab_count_ = slab + 2;
    // A counting sort by slab.
    std::vector<uint32_t> begins(slab + 2, 0);
    for (const Body* body : bodies_) ++begins[slab_of[bucket_of(*body)] + 1];
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    std::vector<Body*> sorted(bodies_.size());
    for (Body* body : bodies_) {
        const uint32_t own = slab_of[bucket_of(*body)], place = begins[own]++;
        sorted[place] = body;
        slabs_[place] = own;
    }
    std::swap(bodies_, sorted);
}

void DebrisSolver::push_guests(const Step& step) {
    if (guests_.empty()) return;
    std::vector<uint32_t> guest_of(bodies_.size(), none);
    for (uint32_t i = 0; i < guests_.size(); ++i) guest_of[guests_[i].body] = i;
    const auto push = [&](const Body& body, const glm::vec3& position, const glm::vec3& impulse,
                          const glm::vec3& torque) {
        if (body.fixed || body.resting) return;
        const uint32_t guest = guest_of[local_[body.index]];
        if (guest == none) return;
        const Velocity change = change_by(body, position, impulse, torque);
        guests_[guest].pushed.linear += change.linear;
        guests_[guest].pushed.angular += change.angular;
    };
    for (const AnyManifold& manifold : manifolds_) {
        if (EllipsoidManifold* const of = manifold.ellipsoids) {
            for (const EllipsoidPoint& point : of->points()) {
                const glm::vec3 impulse =
                    step.row_substeps * (point.start.normal * point.normal + point.start.friction);
                const glm::vec3 torque = step.row_substeps * point.rolling;
                push(*of->a, point.position, impulse, torque);
                push(*of->b, point.position, -impulse, -torque);
            }
        } else if (Manifold* const between = manifold.between) {
            for (const ContactPoint& point : between->points()) {
                const glm::vec3 impulse =
                    step.row_substeps * (point.start.normal * point.normal + point.start.friction);
                const glm::vec3 position = 0.5f * (point.on_a + point.on_b);
                push(between->a(), position, impulse, {});
                push(between->b(), position, -impulse, {});
            }
        }
    }
    for (const Guest& guest : guests_) {
        bodies_[guest.body]->velocity.linear += guest.pushed.linear;
        bodies_[guest.body]->velocity.angular += guest.pushed.angular;
    }
}

void DebrisSolver::colour_points() {
    components_.resize(bodies_.size());
    std::iota(components_.begin(), components_.end(), 0u);
    colours_.assign(colour_kinds * bodies_.size(), 0);
    points_.clear();
    solved_firsts_.clear();
    uint32_t solved = 0;
    const uint32_t far = slab_count_ - 1;
    for (uint32_t m = 0; m < manifolds_.size(); ++m) {
        const AnyManifold& manifold = manifolds_[m];
        solved_firsts_.push_back(solved);
        if (manifold.between) solved += manifold.count;
        if (manifold.count == 0) continue;
        uint32_t a = manifold.a_moves ? local_[manifold.a] : none, b = manifold.b_moves ? local_[manifold.b] : none;
        if (a == none) std::swap(a, b);
        const bool two_sided = b != none;
        uint32_t slab = slabs_[a];
        size_t kind_a = static_colours, kind_b = static_colours;
        if (two_sided) {
            const uint32_t low = std::min(slab, slabs_[b]), high = std::max(slab, slabs_[b]);
            slab = high - low > 1 ? far : low;
            kind_a = kind_b = slab == far ? far_colours : slab % 2;
            fracture::unite(components_, a, b);
        }
        for (uint32_t i = 0; i < manifold.count; ++i) {
            uint64_t& used_a = colours_[colour_kinds * a + kind_a];
            uint64_t& used_b = two_sided ? colours_[colour_kinds * b + kind_b] : used_a;
            const auto colour = static_cast<uint32_t>(std::countr_one(used_a | used_b));
            uint32_t key = uncoloured;
            if (colour < pair_colours) {
                used_a |= uint64_t{1} << colour;
                used_b |= uint64_t{1} << colour;
                key = two_sided ? colour : static_key + colour;
            }
            points_.push_back({m, i, a, b, slab * keys_of_slab + key});
        }
    }
    solved_.resize(solved);
    for (uint32_t i = 0; i < bodies_.size(); ++i) components_[i] = fracture::root_of(components_, i);
}

void DebrisSolver::make_groups(const Step& step, fracture::Threads& threads) {
    const uint32_t keys = slab_count_ * keys_of_slab;
    starts_.assign(keys, 0);
    for (const Point& point : points_) ++starts_[point.key];
    slab_begins_.assign(1, 0);
    static_begins_.clear();
    one_sided_.clear();
    uint32_t groups = 0;
    for (uint32_t key = 0; key < keys; ++key) {
        const uint32_t kind = key % keys_of_slab;
        const uint32_t made = kind == uncoloured ? starts_[key] : (starts_[key] + 3) / 4;
        one_sided_.insert(one_sided_.end(), made, kind >= static_key);
        starts_[key] = 4 * groups;
        groups += made;
        if (kind == uncoloured) static_begins_.push_back(groups);
        if (kind + 1 == keys_of_slab) slab_begins_.push_back(groups);
    }
    constexpr uint32_t empty = none;
    sorted_.assign(size_t{4} * groups, empty);
    lanes_.resize(points_.size());
    for (uint32_t i = 0; i < points_.size(); ++i) {
        uint32_t& next = starts_[points_[i].key];
        lanes_[i] = next;
        sorted_[next] = i;
        next += points_[i].key % keys_of_slab == uncoloured ? 4 : 1;
    }
    groups_.resize(groups);
    threads.for_chunks(groups, min_groups, [&](uint32_t, uint32_t begin, uint32_t end) {
        uint32_t slab = 0;
        for (uint32_t group = begin; group < end; ++group) {
            while (slab_begins_[slab + 1] <= group) ++slab;
            DebrisRows& rows = groups_[group];
            rows = {};
            const auto nobody = static_cast<uint32_t>(bodies_.size()) + slab;
            rows.a.fill(nobody);
            rows.b.fill(nobody);
            for (size_t lane = 0; lane < 4; ++lane)
                if (const uint32_t point = sorted_[4 * group + lane]; point != empty)
                    fill_lane(rows, lane, points_[point], step);
        }
    });
}

void DebrisSolver::fill_lane(DebrisRows& rows, size_t lane, const Point& point, const Step& step) const {
    const AnyManifold& manifold = manifolds_[point.manifold];
    const float scale = step.row_substeps / static_cast<float>(substeps);
    glm::vec3 position, normal;
    float distance, slop, rolling_arm = 0.0f, push = step.push_part;
    PointImpulse start;
    glm::vec3 rolling(0.0f);
    if (const EllipsoidManifold* const of = manifold.ellipsoids) {
        const EllipsoidPoint& from = of->point;
        position = from.position;
        normal = from.normal;
        distance = from.distance;
        slop = of->slop;
        rolling_arm = of->rolling_arm;
        rolling = from.rolling;
        start = from.start;
    } else if (const GroundManifold* const ground = manifold.ground) {
        const GroundPoint& from = ground->all[point.index];
        position = from.position;
        normal = {0, 1, 0};
        distance = from.distance;
        slop = ground->slop;
        push = step.static_push_part;
        start = from.start;
    } else {
        const ContactPoint& from = manifold.between->points()[point.index];
        const bool swapped = !manifold.a_moves, one_sided = swapped || !manifold.b_moves;
        position = !one_sided ? 0.5f * (from.on_a + from.on_b) : swapped ? from.on_b : from.on_a;
        normal = swapped ? -from.normal : from.normal;
        distance = from.distance;
        slop = manifold.between->slop();
        if (one_sided) push = step.static_push_part;
        start = {from.start.normal, swapped ? -from.start.friction : from.start.friction};
    }
    const Body& a = *bodies_[point.a];
    const Body* const b = point.b == none ? nullptr : bodies_[point.b];
    const glm::vec3 arm_a = position - a.frame.origin, arm_b = b ? position - b->frame.origin : glm::vec3(0.0f);
    const Tangents tangents = tangents_of(normal);
    float inverse_mass = 0.0f, response = 0.0f, along_11 = 0.0f, along_12 = 0.0f, along_22 = 0.0f;
    glm::mat3 turning(0.0f);
    const auto add = [&](const Body& body, const glm::vec3& arm) {
        if (body.resting) return;
        inverse_mass += body.inverse_mass;
        turning += body.inverse_inertia;
        const glm::vec3 across = glm::cross(arm, normal), first = glm::cross(arm, tangents.first),
                        second = glm::cross(arm, tangents.second);
        response += glm::dot(across, body.inverse_inertia * across);
        const glm::vec3 turned = body.inverse_inertia * first;
        along_11 += glm::dot(first, turned);
        along_12 += glm::dot(second, turned);
        along_22 += glm::dot(second, body.inverse_inertia * second);
    };
    add(a, arm_a);
    if (b) add(*b, arm_b);
    rows.a[lane] = point.a;
    if (b) rows.b[lane] = point.b;
    put(rows.normal, lane, normal);
    put(rows.arm_a, lane, arm_a);
    put(rows.arm_b, lane, arm_b);
    rows.gap[lane] = distance;
    rows.slop[lane] = slop;
    rows.push[lane] = push / static_cast<float>(substeps);
    const glm::vec3 apart = a.velocity.at(arm_a) - (b ? b->velocity.at(arm_b) : glm::vec3(0.0f));
    put(rows.apart, lane, apart);
    const float approach = -glm::dot(normal, apart);
    rows.bounce[lane] = approach < step.min_bounce_speed ? 0.0f : approach * manifold.restitution();
    put(rows.turning, lane, a.velocity.angular - (b ? b->velocity.angular : glm::vec3(0.0f)));
    if (inverse_mass > 0.0f) {
        rows.normal_mass[lane] = 1.0f / (inverse_mass + response);
        rows.friction_mass[lane] = 1.0f / (inverse_mass + largest_eigenvalue(along_11, along_12, along_22));
        rows.rolling_mass[lane] = rolling_arm > 0.0f ? 1.0f / bound_of(turning) : 0.0f;
    }
    rows.coefficient[lane] = manifold.friction();
    rows.rolling_arm[lane] = rolling_arm;
    rows.impulse[lane] = rows.start[lane] = start.normal * scale;
    put(rows.friction, lane, start.friction * scale);
    put(rows.rolling, lane, rolling * scale);
}

void DebrisSolver::take_bodies(fracture::Threads& threads) {
    const auto count = static_cast<uint32_t>(bodies_.size());
    state_.motions.assign(count + slab_count_, {});
    state_.inverse_inertias.assign(count + slab_count_, {});
    state_.moved.assign(count + slab_count_, {});
    threads.for_chunks(count, min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            const Body& body = *bodies_[i];
            if (body.resting) continue;
            const glm::mat3& m = body.inverse_inertia;
            state_.inverse_inertias[i] = {{m[0].x, m[1].y, m[2].z, 0.0f}, {m[0].y, m[0].z, m[1].z, 0.0f}};
            state_.motions[i].linear[3] = body.inverse_mass;
        }
    });
}

// Contacts with static bodies come last, so that a sweep ends with nothing moving into them.
void DebrisSolver::sweep(fracture::Threads& threads, const auto& solve_groups) {
    const uint32_t far = slab_count_ - 1;
    const auto each = [&](uint32_t tasks, const auto& solve_task) {
        if (groups_.size() < min_groups || tasks < 2)
            for (uint32_t task = 0; task < tasks; ++task) solve_task(task);
        else
            threads.for_each(tasks, solve_task);
    };
    for (uint32_t parity = 0; parity < 2; ++parity)
        each((far + 1 - parity) / 2, [&](uint32_t task) {
            const uint32_t slab = 2 * task + parity;
            solve_groups(slab_begins_[slab], static_begins_[slab]);
        });
    solve_groups(slab_begins_[far], static_begins_[far]);
    each(far, [&](uint32_t slab) { solve_groups(static_begins_[slab], slab_begins_[slab + 1]); });
}

void DebrisSolver::solve(const Step& step, fracture::Threads& threads) {
    if (bodies_.empty()) {
        solved_.clear();
        return;
    }
    start_guests();
    colour_points();
    make_groups(step, threads);
    take_bodies(threads);
    const float seconds = step.seconds / static_cast<float>(substeps);
    const float longest_push = step.separation_speed * seconds;
    const auto each_group = [&](const auto& two_sided, const auto& one_sided) {
        sweep(threads, [&](uint32_t begin, uint32_t end) {
            for (uint32_t i = begin; i < end; ++i) one_sided_[i] != 0 ? one_sided(groups_[i]) : two_sided(groups_[i]);
        });
    };
    for (int substep = 1; substep <= substeps; ++substep) {
        add_forces(step.gravity * seconds);
        free_ = state_.motions;
        each_group([&](DebrisRows& rows) { start_substep<true>(rows, state_); },
                   [&](DebrisRows& rows) { start_substep<false>(rows, state_); });
        each_group([&](DebrisRows& rows) { solve_first<true>(rows, state_, seconds, longest_push); },
                   [&](DebrisRows& rows) { solve_first<false>(rows, state_, seconds, longest_push); });
        move_bodies(substep, seconds, threads);
        each_group([&](DebrisRows& rows) { solve_second<true>(rows, state_); },
                   [&](DebrisRows& rows) { solve_second<false>(rows, state_); });
        for (int i = 0; i < (substep < substeps ? 0 : bounce_sweeps); ++i)
            each_group([&](DebrisRows& rows) { solve_bounce<true>(rows, state_); },
                       [&](DebrisRows& rows) { solve_bounce<false>(rows, state_); });
        limit_energy(step.gravity * seconds, threads);
        threads.for_chunks(static_cast<uint32_t>(groups_.size()), min_groups,
                           [&](uint32_t, uint32_t begin, uint32_t end) {
                               for (uint32_t i = begin; i < end; ++i) finish_substep(groups_[i]);
                           });
    }
    store_points(step, threads);
    store_bodies(step, threads);
}

// Guests start with their velocities before RowSolver; what it changed acts on them in equal parts.
void DebrisSolver::start_guests() {
    constexpr float part = 1.0f / static_cast<float>(substeps);
    for (Guest& guest : guests_) {
        Body& body = *bodies_[guest.body];
        guest.driven = {(body.velocity.linear - guest.before.linear - guest.pushed.linear) * part,
                        (body.velocity.angular - guest.before.angular - guest.pushed.angular) * part};
        guest.motion = body.motion;
        body.velocity = guest.before;
    }
}

void DebrisSolver::add_forces(const glm::vec3& fall) {
    for (uint32_t i = 0; i < bodies_.size(); ++i)
        if (is_guest_[i] == 0 && !bodies_[i]->resting)
            for (int axis = 0; axis < 3; ++axis) state_.motions[i].linear[axis] += fall[axis];
    for (const Guest& guest : guests_) {
        const Body& body = *bodies_[guest.body];
        if (body.resting) continue;
        const glm::vec3 momentum = momentum_of(body, guest.driven.angular);
        DebrisBodies::Motion& motion = state_.motions[guest.body];
        for (int axis = 0; axis < 3; ++axis) {
            motion.linear[axis] += guest.driven.linear[axis];
            motion.momentum[axis] += momentum[axis];
        }
    }
}

// As RowSolver::limit_energy(): the impulses of a substep add no more kinetic energy to a component of bodies than a
// fall from rest does. Otherwise what starts a substep after a blow would throw pieces up.
void DebrisSolver::limit_energy(const glm::vec3& fall, fracture::Threads& threads) {
    const auto count = static_cast<uint32_t>(bodies_.size());
    const float square_fall = 0.5f * glm::dot(fall, fall);
    added_.resize(count);
    threads.for_chunks(count, min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            const Body& body = *bodies_[i];
            added_[i] = {};
            if (body.resting) continue;
            const DebrisBodies::Motion &free = free_[i], &now = state_.motions[i];
            const glm::vec3 linear = vec3_of(now.linear) - vec3_of(free.linear);
            const glm::vec3 momentum = vec3_of(now.momentum) - vec3_of(free.momentum);
            const glm::vec3 spin = body.velocity.angular + body.inverse_inertia * vec3_of(free.momentum);
            added_[i] = {
                .linear = body.mass * glm::dot(body.velocity.linear + vec3_of(free.linear), linear)
                          + glm::dot(spin, momentum),
                .square =
                    0.5f * (body.mass * glm::dot(linear, linear) + glm::dot(momentum, body.inverse_inertia * momentum)),
                .allowed = body.mass * square_fall};
        }
    });
    for (uint32_t i = 0; i < count; ++i) { // a root has the lowest index of its component
        if (components_[i] == i) continue;
        AddedEnergy& sum = added_[components_[i]];
        sum.linear += added_[i].linear;
        sum.square += added_[i].square;
        sum.allowed += added_[i].allowed;
    }
    shares_.assign(count + slab_count_, 1.0f);
    bool any = false;
    for (uint32_t i = 0; i < count; ++i) {
        shares_[i] = components_[i] == i ? added_[i].share() : shares_[components_[i]];
        any = any || shares_[i] < 1.0f;
    }
    if (!any) return;
    for (uint32_t i = 0; i < count; ++i) {
        if (!(shares_[i] < 1.0f)) continue;
        DebrisBodies::Motion& now = state_.motions[i];
        for (int axis = 0; axis < 3; ++axis) {
            now.linear[axis] = free_[i].linear[axis] + shares_[i] * (now.linear[axis] - free_[i].linear[axis]);
            now.momentum[axis] = free_[i].momentum[axis] + shares_[i] * (now.momentum[axis] - free_[i].momentum[axis]);
        }
    }
    for (DebrisRows& rows : groups_) {
        Four share;
        for (size_t lane = 0; lane < 4; ++lane) share[lane] = shares_[rows.a[lane]];
        scale(rows, share);
    }
}

void DebrisSolver::move_bodies(int substep, float seconds, fracture::Threads& threads) {
    threads.for_chunks(static_cast<uint32_t>(bodies_.size()), min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            const Body& body = *bodies_[i];
            if (body.resting) continue;
            const Velocity now = velocity_of(i);
            for (int axis = 0; axis < 3; ++axis) {
                state_.moved[i].linear[axis] += now.linear[axis] * seconds;
                state_.moved[i].angular[axis] += now.angular[axis] * seconds;
            }
        }
    });
    // Guests move as RowSolver moved them, and by the contacts with debris.
    for (const Guest& guest : guests_) {
        const auto parts = static_cast<float>(substep);
        const glm::vec3 linear = guest.motion.linear - guest.before.linear - parts * guest.driven.linear;
        const glm::vec3 angular = guest.motion.angular - guest.before.angular - parts * guest.driven.angular;
        for (int axis = 0; axis < 3; ++axis) {
            state_.moved[guest.body].linear[axis] += linear[axis] * seconds;
            state_.moved[guest.body].angular[axis] += angular[axis] * seconds;
        }
    }
}

Velocity DebrisSolver::velocity_of(uint32_t i) const {
    const Body& body = *bodies_[i];
    return {body.velocity.linear + vec3_of(state_.motions[i].linear),
            body.velocity.angular + body.inverse_inertia * vec3_of(state_.motions[i].momentum)};
}

void DebrisSolver::store_points(const Step& step, fracture::Threads& threads) {
    const float scale = static_cast<float>(substeps) / step.row_substeps;
    threads.for_chunks(
        static_cast<uint32_t>(points_.size()), min_manifolds, [&](uint32_t, uint32_t begin, uint32_t end) {
            for (uint32_t i = begin; i < end; ++i) {
                const Point& point = points_[i];
                const AnyManifold& manifold = manifolds_[point.manifold];
                const DebrisRows& rows = groups_[lanes_[i] / 4];
                const size_t lane = lanes_[i] % 4;
                const bool swapped = !manifold.ground && !manifold.a_moves;
                const glm::vec3 normal = get(rows.normal, lane), arm_a = get(rows.arm_a, lane);
                const PointImpulse last{rows.total[lane],
                                        swapped ? -get(rows.friction_total, lane) : get(rows.friction_total, lane)};
                const PointImpulse start{rows.impulse[lane] * scale,
                                         (swapped ? -get(rows.friction, lane) : get(rows.friction, lane)) * scale};
                const Body& a = *bodies_[point.a];
                const glm::vec3 position = a.frame.origin + arm_a;
                const auto before_at = [&](uint32_t body) {
                    return body == none ? glm::vec3(0.0f)
                                        : Velocity{bodies_[body]->unhindered.linear - step.gravity * step.seconds,
                                                   bodies_[body]->unhindered.angular}
                                              .at(position - bodies_[body]->frame.origin);
                };
                const float speed = glm::dot(normal, before_at(point.b) - before_at(point.a));
                if (manifold.ground) {
                    GroundPoint& to = manifold.ground->all[point.index];
                    to.last = last, to.start = start, to.speed = speed;
                } else if (manifold.ellipsoids) {
                    EllipsoidPoint& to = manifold.ellipsoids->point;
                    to.last = last, to.start = start, to.speed = speed;
                    to.rolling = get(rows.rolling, lane) * scale;
                } else {
                    ContactPoint& to = manifold.between->points()[point.index];
                    to.last = last, to.start = start;
                    solved_[solved_firsts_[point.manifold] + point.index] = {.manifold = manifold.between,
                                                                             .point = &to,
                                                                             .position = position,
                                                                             .distance = to.distance,
                                                                             .speed = speed,
                                                                             .impulse = last.normal,
                                                                             .friction = last.friction};
                }
            }
        });
}

void DebrisSolver::store_bodies(const Step& step, fracture::Threads& threads) {
    std::vector<uint8_t> acted(bodies_.size(), 0);
    for (size_t i = 0; i < points_.size(); ++i) {
        const DebrisRows& rows = groups_[lanes_[i] / 4];
        const size_t lane = lanes_[i] % 4;
        if (rows.total[lane] <= 0.0f && rows.pushed[lane] <= 0.0f) continue;
        acted[points_[i].a] = 1;
        if (points_[i].b != none) acted[points_[i].b] = 1;
    }
    const float rate = 1.0f / step.seconds;
    const glm::vec3 fall = step.gravity * step.seconds;
    threads.for_chunks(static_cast<uint32_t>(bodies_.size()), min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            Body& body = *bodies_[i];
            if (body.resting) {
                body.velocity = body.motion = {};
                continue;
            }
            if (acted[i] == 0 && is_guest_[i] == 0) { // falls along its parabola
                body.motion = {body.velocity.linear + 0.5f * fall, body.velocity.angular};
                body.velocity.linear += fall;
                continue;
            }
            body.velocity = velocity_of(i);
            body.motion = {vec3_of(state_.moved[i].linear) * rate, vec3_of(state_.moved[i].angular) * rate};
        }
    });
}

} // namespace brittle::physics
