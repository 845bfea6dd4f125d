#include "physics/solver/solver.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "physics/solver/free_rotation.h"
#include "physics/solver/manifold.h"
#include "physics/solver/narrow_phase.h"
#include "physics/solver/parallel_loops.h"
#include "physics/solver/prefetch.h"
#include "physics/world/world_check.h"

namespace brittle::physics {

namespace {

// Bounds reach so far around the hulls, m: contacts begin before bodies touch.
constexpr float bounds_slack = 2e-3f;
// m; a body whose path in a step is longer is astray.
constexpr float longest_way = 1e5f;
// Drag below this part of gravity is skipped: otherwise falling siblings would not move as one, and all their contacts
// would be searched.
constexpr float unfelt_part = 0.03f;
// Fewer bodies than this are not worth waking another thread for.
constexpr uint32_t min_bodies = 64, min_new_bodies = 32, min_poses = 256;

// rad; upper bound of the rotation in a step when the path ahead is predicted.
constexpr float max_predicted_angle = 0.5f * 1.57079632679489661923f;

// Where the body is after a step at its present velocity, its rotation rate taken as constant (the exponential map).
Transform predicted(const Body& body, float seconds) {
    const glm::vec3& angular = body.velocity.angular;
    constexpr float epsilon = 1.1920929e-7f;
    const float square = length_squared(angular);
    float rate = square > epsilon ? std::sqrt(square) : 0.0f;
    if (rate * seconds > max_predicted_angle) rate = max_predicted_angle / seconds;
    const float factor = rate < 0.001f
                             ? 0.5f * seconds - (seconds * seconds * seconds) * 0.020833333333f * rate * rate // Taylor
                             : std::sin(0.5f * rate * seconds) / rate;
    const glm::vec3 axis = angular * factor;
    const glm::quat turn(std::cos(rate * seconds * 0.5f), axis.x, axis.y, axis.z);
    glm::quat orientation = turn * rotation_of(body.frame.basis);
    const float norm = orientation.x * orientation.x + orientation.y * orientation.y + orientation.z * orientation.z
                       + orientation.w * orientation.w;
    if (norm > epsilon) orientation = orientation * (1.0f / std::sqrt(norm));
    return {norm > epsilon ? matrix_of(orientation) : body.frame.basis,
            body.frame.origin + body.velocity.linear * seconds};
}

// Prefetches for the bounds of the next bodies: the bodies, their forms and proxies, and the points of their hulls.
[[gnu::always_inline]] inline void prefetch_hulls(std::span<Body* const> bodies) {
    constexpr size_t points_ahead = 2, form_ahead = 4, body_ahead = 6;
    if (bodies.size() > body_ahead) prefetch(bodies[body_ahead]);
    if (bodies.size() > form_ahead) {
        prefetch(bodies[form_ahead]->form.get());
        prefetch(bodies[form_ahead]->proxy);
    }
    if (bodies.size() <= points_ahead || bodies[points_ahead]->compound) return;
    const std::span<const float> points = bodies[points_ahead]->hull().groups();
    prefetch(points.data(), points.size_bytes());
}

fracture::Error refused(BodyId id, const fracture::Error& fault) {
    return {fault.status, text(id, " cannot be added: ", fault.message)};
}

void add(StateHash& hash, const glm::vec3& v) {
    for (int axis = 0; axis < 3; ++axis) hash.add(v[axis]);
}

} // namespace

std::unique_ptr<Engine> make_solver(const WorldSettings& settings) {
    return std::make_unique<Solver>(settings);
}

Solver::Solver(const WorldSettings& settings) : settings_(settings), threads_(settings.threads) {
    if (settings.ground_height)
        broadphase_.add(std::make_unique<SweptProxy>(
            SweptProxy{.bounds = {glm::vec3(-unbounded), glm::vec3(unbounded)}, .fixed = true}));
}

// Bodies of one hull are made side by side, and left alone afterwards: half of them lie in another core's cache.
Result<void> Solver::add(size_t number, BodyId first, const Describe& describe, std::span<Pose> previous) {
    const auto count = static_cast<uint32_t>(number);
    std::vector<NewBody> made(count);
    std::vector<std::optional<fracture::Error>> faults(
        threads_.chunks(count, min_new_bodies)); // the first of each chunk
    threads_.for_chunks(count, min_new_bodies, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        BodyDesc storage;
        for (uint32_t i = begin; i < end; ++i) {
            const BodyId id{first.value + i};
            const BodyDesc& desc = describe(i, storage);
            Result<NewBody> body = make_body(desc, settings_);
            if (!body) {
                faults[chunk] = refused(id, body.error());
                return;
            }
            made[i] = std::move(*body);
            made[i].body->id = id;
            made[i].body->index = static_cast<uint32_t>(bodies_.size()) + i;
            previous[i] = desc.previous ? Pose{desc.previous->position, glm::normalize(desc.previous->orientation)}
                                        : made[i].body->pose_in(made[i].body->rewind_frame);
        }
    });
    for (const std::optional<fracture::Error>& fault : faults)
        if (fault) return *fault;
    BodyDesc storage;
    for (uint32_t i = 0; i < count; ++i) {
        Body& body = *made[i].body;
        if (!made[i].proxy) {
            const BodyDesc& desc = describe(i, storage);
            finish_compound(made[i], compound_of(body, desc), desc, settings_);
        }
        if (body.awake()) ++awake_.of(body.debris);
    }
    for (NewBody& body : made) {
        siblings_.add(*body.body);
        broadphase_.add(std::move(body.proxy));
        bodies_.push_back(std::move(body.body));
    }
    contacts_.forget_sleeping();
    return {};
}

std::unique_ptr<CompoundShape> Solver::compound_of(const Body& body, const BodyDesc& desc) {
    const glm::quat from_body = glm::conjugate(body.to_principal);
    const glm::mat3 basis = matrix_of(from_body);
    std::vector<CompoundShape::Child> children;
    for (const BodyPart& part : desc.parts)
        children.push_back({shared_hull(part.hull), {basis, (from_body * part.offset)}});
    return std::make_unique<CompoundShape>(std::move(children));
}

std::shared_ptr<SharedHull> Solver::shared_hull(const std::shared_ptr<const CollisionHull>& hull) {
    if (const auto known = shared_hulls_.find(hull.get()); known != shared_hulls_.end()) return known->second;
    if (shared_hulls_.size() >= max_shared_hulls_) {
        std::erase_if(shared_hulls_, [](const auto& entry) { return entry.second.use_count() == 1; });
        max_shared_hulls_ = std::max<size_t>(64, 2 * shared_hulls_.size());
    }
    std::vector<glm::vec3> points;
    points.reserve(hull->points.size());
    for (const glm::vec3& point : hull->points) points.push_back(point);
    HullFaces faces = hull->faces.count() == 0 ? hull_faces(points) : hull->faces;
    auto made = std::make_shared<SharedHull>(SharedHull{hull, {std::move(points), hull->margin, std::move(faces)}, {}});
    shared_hulls_.emplace(hull.get(), made);
    return made;
}

void Solver::remove(size_t index) {
    Body& body = *bodies_[index];
    (void)contacts_.solved_contacts(); // reports the contacts while the body exists
    siblings_.remove(body);
    std::vector<AnyManifold> manifolds;
    for (const uint32_t pair_index : broadphase_.pairs().pairs_of(*body.proxy)) {
        const SweptPair& pair = broadphase_.pairs().at(pair_index);
        Body* const other = pair.a->body == &body ? pair.b->body : pair.a->body;
        if (!other || !pair.contacts) continue;
        manifolds.clear();
        pair.contacts->collect(manifolds);
        if (!manifolds.empty()) wake(*other);
    }
    broadphase_.remove(*body.proxy);
    std::erase(moved_on_, &body);
    if (body.awake()) --awake_.of(body.debris);
    contacts_.forget_sleeping();
    bodies_.erase(bodies_.begin() + static_cast<std::ptrdiff_t>(index));
    for (size_t i = index; i < bodies_.size(); ++i) bodies_[i]->index = static_cast<uint32_t>(i);
}

void Solver::add_joint(JointId id, const Joint& joint, const JointBodies& bodies) {
    const auto body_of = [&](size_t index) { return index == JointBodies::none ? nullptr : bodies_[index].get(); };
    SolverJoint made{.id = id,
                     .kind = joint.kind,
                     .a = body_of(bodies.a),
                     .b = body_of(bodies.b),
                     .anchor_a = joint.a.anchor,
                     .anchor_b = joint.b.anchor,
                     .axis_a = joint.a.axis,
                     .axis_b = joint.b.axis,
                     .up_a = joint.a.up,
                     .up_b = joint.b.up,
                     .min_length = joint.min_length,
                     .max_length = joint.max_length,
                     .max_force = joint.max_force,
                     .max_torque = joint.max_torque,
                     .bears_pressure = joint.bears_pressure,
                     .collide = joint.collide};
    const auto to_frame = [](const Body* body, glm::vec3& v) {
        if (body) v = glm::conjugate(body->to_principal) * v;
    };
    for (glm::vec3* v : {&made.anchor_a, &made.axis_a, &made.up_a}) to_frame(made.a, *v);
    for (glm::vec3* v : {&made.anchor_b, &made.axis_b, &made.up_b}) to_frame(made.b, *v);
    joints_.add(made);
    for (Body* body : {made.a, made.b})
        if (body) wake(*body);
}

void Solver::remove_joint(JointId id) {
    const SolverJoint joint = joints_.remove(id);
    for (Body* body : {joint.a, joint.b})
        if (body) wake(*body);
}

void Solver::wake(Body& body) {
    body.still_seconds = body.quiet_seconds = body.rest_seconds = 0.0f;
    if (!settings_.sleeping || body.fixed) return;
    if (!body.awake()) ++awake_.of(body.debris);
    body.activity = Activity::awake;
}

void Solver::step() {
    moved_on_.clear();
    stepped_.clear();
    for (const auto& body : bodies_)
        if (body->awake()) stepped_.push_back(body.get());
    start_bodies();
    broadphase_.find_pairs();
    const std::optional<float>& ground = settings_.ground_height;
    siblings_.check(broadphase_.pairs(), ground ? std::optional(*ground) : std::nullopt);
    brake_by_air();
    find_contacts(broadphase_.pairs(),
                  {.seconds = settings_.step,
                   .gravity = settings_.gravity.y,
                   .ground_height = ground.value_or(0.0f),
                   .ground_friction = settings_.ground_friction,
                   .ground_restitution = settings_.ground_restitution},
                  threads_);
    find_islands();
    solve_contacts();
    move_bodies();
    if (settings_.sleeping) sleeping_.settle(settings_.step);
    note_moved();
}

void Solver::start_bodies() {
    const float linear_kept = std::pow(1.0f - settings_.linear_damping, settings_.step);
    const float angular_kept = std::pow(1.0f - settings_.angular_damping, settings_.step);
    threads_.for_chunks(static_cast<uint32_t>(stepped_.size()), min_bodies,
                        [&](uint32_t, uint32_t begin, uint32_t end) {
                            for (uint32_t i = begin; i < end; ++i) {
                                prefetch_hulls(std::span(stepped_).subspan(i, end - i));
                                Body& body = *stepped_[i];
                                body.step_start = body.frame;
                                body.velocity.linear *= linear_kept;
                                body.velocity.angular *= angular_kept;
                                set_bounds(body);
                            }
                        });
}

// Sets bounds that contain the body throughout the step. Bounds of a body that hardly rotates are computed once.
void Solver::set_bounds(Body& body) {
    const float seconds = settings_.step;
    Bounds bounds = body.bounds(body.frame);
    float slack = bounds_slack;
    const float rotation = glm::length(body.velocity.angular) * seconds;
    if (!body.compound && rotation * body.reach < slack) {
        const glm::vec3 way = body.velocity.linear * seconds;
        slack += rotation * body.reach;
        bounds = both(bounds, {bounds.low + way, bounds.high + way});
    } else {
        bounds = both(bounds, body.bounds(predicted(body, seconds)));
    }
    // A body that went astray, or whose place is not a number, stays where it last was.
    if (glm::length(bounds.high - bounds.low) < longest_way)
        broadphase_.set_bounds(*body.proxy, {bounds.low - glm::vec3(slack), bounds.high + glm::vec3(slack)});
    else
        body.set_activity(Activity::astray);
}

// Follows the check of siblings, because drag differs between the pieces of a cut: before it, they would not move as
// one.
void Solver::brake_by_air() {
    if (!(settings_.air_density > 0.0f)) return;
    const float unfelt = unfelt_part * glm::length(settings_.gravity) * settings_.step;
    threads_.for_chunks(
        static_cast<uint32_t>(stepped_.size()), min_bodies, [&](uint32_t, uint32_t begin, uint32_t end) {
            for (uint32_t i = begin; i < end; ++i) {
                if (i + 2 * prefetch_distance < end) prefetch(stepped_[i + 2 * prefetch_distance]);
                if (i + prefetch_distance < end) prefetch(&stepped_[i + prefetch_distance]->form->drag);
                Body& body = *stepped_[i];
                body.form->drag.brake(body.velocity, body.frame.basis, settings_.air_density, settings_.step, unfelt);
            }
        });
}

void Solver::find_islands() {
    islands_.find(bodies_, stepped_, joints_.pairs(), broadphase_, threads_);
    for (Body* body : islands_.woken()) {
        body->step_start = body->frame;
        stepped_.push_back(body);
    }
    for (Body* body : islands_.fallen_asleep()) {
        body->velocity = body->unhindered = body->solved = {};
        body->rewind_frame = body->frame;
    }
}

void Solver::solve_contacts() {
    if (settings_.sleeping) sleeping_.update_resting(settings_.step);
    const glm::vec3 fall = settings_.gravity * settings_.step;
    for_each_body(islands_.awake(), threads_, [&](Body& body) {
        body.unhindered = body.velocity;
        if (!body.resting) body.unhindered.linear += fall;
        body.moving_seconds = settings_.step;
        body.stopped_by = {};
    });
    joints_.start({settings_.step, settings_.step / static_cast<float>(settings_.solver_substeps)}, bodies_.size());
    contacts_.solve(islands_.awake(), islands_.manifolds(), joints_, threads_);
}

void Solver::move_bodies() {
    for (const ContinuousCollision::Stop& stop : continuous_collision_.find(islands_.awake(), settings_.step)) {
        stop.body->moving_seconds = stop.seconds;
        stop.body->stopped_by = stop.by;
        lose_fall(*stop.body, settings_.step - stop.seconds);
    }
    for_each_body(islands_.awake(), threads_, [](Body& body) { move(body, body.moving_seconds); });
    joints_.correct(threads_);
}

// A body that stops for the rest of a step gains no speed of fall in that time, because it does not fall. A body that a
// contact holds up has gained none.
void Solver::lose_fall(Body& body, float seconds) const {
    const glm::vec3 fallen = settings_.gravity * seconds, before = body.velocity.linear - fallen;
    if (length_squared(before) >= length_squared(body.velocity.linear)) return;
    body.velocity.linear = before;
    body.unhindered.linear -= fallen; // rewind() gives it back without
}

// Moves the body with its velocity of motion. The velocity after its bounce keeps its angular momentum while the
// orientation changes.
void Solver::move(Body& body, float seconds) {
    body.rewind_frame = body.frame;
    body.rewind_seconds = seconds;
    const Spin spin =
        free_spin({glm::dquat(rotation_of(body.frame.basis)), glm::dvec3(body.motion.angular)}, body.moments, seconds);
    const bool bounced = body.motion.angular != body.velocity.angular;
    glm::dvec3 momentum(0.0);
    if (bounced) {
        const glm::dmat3 axes(body.frame.basis);
        momentum = axes * (body.moments * (glm::dvec3(body.velocity.angular) * axes));
    }
    body.set_frame({matrix_of(glm::quat(spin.orientation)), body.frame.origin + body.motion.linear * seconds});
    if (bounced) {
        const glm::dmat3 axes(body.frame.basis);
        body.velocity.angular = glm::vec3(axes * ((momentum * axes) / body.moments));
    } else {
        body.velocity.angular = glm::vec3(spin.velocity);
    }
    body.solved = body.velocity;
}

void Solver::note_moved() {
    moved_.assign(bodies_.size(), 0);
    std::atomic<size_t> colliding = 0, debris = 0;
    threads_.for_chunks(static_cast<uint32_t>(stepped_.size()), min_poses, [&](uint32_t, uint32_t begin, uint32_t end) {
        AwakeCount count;
        for (const Body* body : std::span(stepped_).subspan(begin, end - begin)) {
            moved_[body->index] = body->has_moved();
            if (body->awake()) ++count.of(body->debris);
        }
        colliding += count.colliding;
        debris += count.debris;
    });
    awake_ = {.colliding = colliding, .debris = debris};
}

void Solver::write_poses(std::span<const uint64_t> moved_steps, uint64_t since, std::span<Pose> out) const {
    threads_.for_chunks(static_cast<uint32_t>(out.size()), min_poses, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (size_t i = begin; i < end; ++i)
            if (moved_steps[i] >= since) out[i] = bodies_[i]->pose();
    });
}

void Solver::apply_impulse(size_t index, const glm::vec3& impulse, const glm::vec3& point) {
    Body& body = *bodies_[index];
    wake(body);
    const glm::vec3 scaled = impulse;
    body.velocity.linear += scaled * body.inverse_mass;
    body.velocity.angular += body.inverse_inertia * glm::cross(point - body.frame.origin, scaled);
}

void Solver::set_velocity(size_t index, const glm::vec3& linear, const glm::vec3& angular) {
    Body& body = *bodies_[index];
    wake(body);
    body.velocity = {linear, angular};
}

// Changes of velocity since the step remain.
float Solver::rewind(size_t index) {
    Body& body = *bodies_[index];
    wake(body);
    body.set_frame(body.rewind_frame);
    body.velocity.linear += body.unhindered.linear - body.solved.linear;
    body.velocity.angular += body.unhindered.angular - body.solved.angular;
    body.unhindered = body.solved = body.velocity;
    return body.rewind_seconds;
}

void Solver::move_on(size_t index, float seconds) {
    Body& body = *bodies_[index];
    body.motion = body.velocity;
    move(body, seconds);
    moved_on_.push_back(&body);
}

void Solver::cast_rays(std::span<const Ray> rays, std::span<std::optional<RayHit>> hits) const {
    std::vector<const Body*> strays(moved_on_.begin(), moved_on_.end());
    for (const auto& joint : joints_.all()) // Joints::correct() moves them
        for (const Body* body : {joint->a, joint->b})
            if (body) strays.push_back(body);
    std::ranges::sort(strays, {}, [](const Body* body) { return body->index; });
    strays.erase(std::unique(strays.begin(), strays.end()), strays.end());
    physics::cast_rays(broadphase_, strays, rays, hits);
}

// 1/m + n . (I^-1 (r x n)) x r
float Solver::response(size_t index, const glm::vec3& point, const glm::vec3& direction) const {
    const Body& body = *bodies_[index];
    const glm::vec3 arm = point - body.frame.origin;
    return body.inverse_mass + glm::dot(direction, glm::cross(glm::cross(arm, direction) * body.inverse_inertia, arm));
}

size_t Solver::contact_count() const {
    std::vector<AnyManifold> manifolds;
    for (const SweptPair& pair : broadphase_.pairs().all())
        if (pair.contacts) pair.contacts->collect(manifolds);
    const auto touches = [](const auto& point) { return point.distance < touching_distance; };
    size_t count = 0;
    for (const AnyManifold& manifold : manifolds)
        count += manifold.visit(
            [&](const auto& of) { return static_cast<size_t>(std::ranges::count_if(of.points(), touches)); });
    return count;
}

void Solver::add_state(StateHash& hash) const {
    for (const auto& body : bodies_) {
        physics::add(hash, body->frame.origin);
        for (int axis = 0; axis < 3; ++axis) physics::add(hash, row(body->frame.basis, axis));
        physics::add(hash, body->velocity.linear);
        physics::add(hash, body->velocity.angular);
        hash.add(static_cast<uint8_t>(body->awake()));
    }
}

void Solver::debug_lines(std::vector<DebugLine>& out, const DebugDraw& draw) {
    const auto draw_hull = [&](const HullShape& shape, std::vector<HullEdge>& edges, const Transform& frame,
                               const glm::vec3& colour) {
        if (edges.empty()) edges = hull_edges(shape.points());
        for (const auto& [from, to] : edges)
            out.push_back({frame * shape.points()[from], frame * shape.points()[to], colour});
    };
    for (size_t i = 0; draw.hulls && i < bodies_.size(); ++i) {
        Body& body = *bodies_[i];
        const glm::vec3 colour = hull_colour(body.awake());
        if (!body.compound) {
            draw_hull(body.hull(), body.edges, body.frame, colour);
            continue;
        }
        for (const CompoundShape::Child& child : body.compound->children())
            draw_hull(child.shape(), child.hull->edges, body.frame * child.frame, colour);
    }
    for (const auto& joint : joints_.all()) {
        if (!draw.joints) break;
        const auto point = [](const Body* body, const glm::vec3& at) { return body ? body->frame * at : at; };
        const glm::vec3 a = point(joint->a, joint->anchor_a), b = point(joint->b, joint->anchor_b);
        const glm::vec3 axis = joint->a ? joint->a->frame.basis * joint->axis_a : joint->axis_a;
        out.push_back({a, joint->kind == JointKind::hinge ? a + axis * joint_axis_length : b, joint_colour});
    }
    if (!draw.contacts) return;
    std::vector<AnyManifold> manifolds;
    for (const SweptPair& pair : broadphase_.pairs().all())
        if (pair.contacts) pair.contacts->collect(manifolds);
    const auto draw_contact = [&](const glm::vec3& at, const glm::vec3& normal, float distance) {
        if (distance < touching_distance) out.push_back(contact_line(at, normal));
    };
    for (const AnyManifold& manifold : manifolds) {
        if (manifold.ground)
            for (const GroundPoint& point : manifold.ground->points())
                draw_contact(point.position - glm::vec3(0, point.distance, 0), {0, 1, 0}, point.distance);
        else if (manifold.ellipsoids)
            for (const EllipsoidPoint& point : manifold.ellipsoids->points())
                draw_contact(point.position, point.normal, point.distance);
        else
            for (const ContactPoint& point : manifold.between->points())
                draw_contact(point.on_b, point.normal, point.distance);
    }
}

} // namespace brittle::physics
