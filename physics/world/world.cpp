#include "physics/world/world.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <ostream>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "physics/world/engine.h"
#include "physics/world/joint.h"
#include "physics/world/magnitude.h"
#include "physics/world/state_hash.h"
#include "physics/world/world_check.h"

namespace brittle::physics {

// Handles, time and interpolation; all vectors in body order.
struct World::Impl {
    WorldSettings settings;
    std::unique_ptr<Engine> engine;
    std::vector<BodyId> ids;           // ascending
    std::vector<uint64_t> moved_steps; // World::last_moved_step()
    std::vector<Pose> previous;        // before the last step
    uint32_t next_id = 0;              // only grows
    uint32_t last_siblings = 0;
    uint64_t removed = 0;
    uint64_t steps = 0;
    double pending_seconds = 0.0;
    std::vector<JointId> joint_ids; // ascending
    std::vector<Joint> joints;      // by joint_ids
    uint32_t next_joint = 0;        // only grows

    explicit Impl(const WorldSettings& given) : settings(given), engine(make_engine(given)) {}

    // A binary search: a table indexed by handle would grow without bound in runs that keep breaking bodies.
    [[nodiscard]] std::optional<size_t> find(BodyId id) const {
        const auto at = std::ranges::lower_bound(ids, id);
        return at != ids.end() && *at == id ? std::optional(static_cast<size_t>(at - ids.begin())) : std::nullopt;
    }
    [[nodiscard]] size_t index_of(BodyId id) const {
        const std::optional<size_t> index = find(id);
        assert(index && "no such body in this world");
        return *index;
    }
    [[nodiscard]] std::optional<size_t> find(JointId id) const {
        const auto at = std::ranges::lower_bound(joint_ids, id);
        return at != joint_ids.end() && *at == id ? std::optional(static_cast<size_t>(at - joint_ids.begin()))
                                                  : std::nullopt;
    }
    [[nodiscard]] const Joint& joint(JointId id) const {
        const std::optional<size_t> index = find(id);
        assert(index && "no such joint in this world");
        return joints[*index];
    }
    void insert(JointId id, const Joint& joint) {
        const auto at = std::ranges::lower_bound(joint_ids, id) - joint_ids.begin();
        joint_ids.insert(joint_ids.begin() + at, id);
        joints.insert(joints.begin() + at, joint);
        const auto body = [this](const JointSide& side) {
            return side.body == BodyId{} ? Engine::JointBodies::none : index_of(side.body);
        };
        engine->add_joint(id, joint, {body(joint.a), body(joint.b)});
    }
    void erase(size_t joint) {
        joint_ids.erase(joint_ids.begin() + static_cast<std::ptrdiff_t>(joint));
        joints.erase(joints.begin() + static_cast<std::ptrdiff_t>(joint));
    }
    [[nodiscard]] Pose frame_of(const JointSide& side) const {
        return side.body == BodyId{} ? Pose{} : engine->pose(index_of(side.body));
    }
    [[nodiscard]] glm::vec3 anchor_of(const JointSide& side) const {
        const Pose frame = frame_of(side);
        return frame.position + frame.orientation * side.anchor;
    }
    // The side of a joint at a point and along axes of the world.
    [[nodiscard]] JointSide side_of(BodyId body, const glm::vec3& anchor, const glm::vec3& axis,
                                    const glm::vec3& up) const {
        const Pose frame = frame_of({.body = body});
        const glm::quat to_body = glm::conjugate(frame.orientation);
        return {body, to_body * (anchor - frame.position), to_body * axis, to_body * up};
    }
    [[nodiscard]] Pose interpolated_pose(size_t body, float alpha) const {
        const Pose now = engine->pose(body);
        if (alpha >= 1.0f || moved_steps[body] < steps) return now; // no rounding of a body at rest
        return {glm::mix(previous[body].position, now.position, alpha),
                glm::slerp(previous[body].orientation, now.orientation, alpha)};
    }

    Result<std::vector<BodyId>> add(size_t count, const Engine::Describe& describe) {
        const BodyId first{next_id};
        std::vector<Pose> before(count);
        if (const Result<void> added = engine->add(count, first, describe, before); !added) return added.error();
        std::vector<BodyId> added(count);
        for (size_t i = 0; i < count; ++i) added[i] = {next_id++};
        ids.insert(ids.end(), added.begin(), added.end());
        previous.insert(previous.end(), before.begin(), before.end());
        moved_steps.resize(ids.size(), steps);
        return added;
    }
};

std::ostream& operator<<(std::ostream& stream, BodyId id) {
    return id == BodyId{} ? stream << "body none" : stream << "body " << id.value;
}

std::ostream& operator<<(std::ostream& stream, JointId id) {
    return id == JointId{} ? stream << "joint none" : stream << "joint " << id.value;
}

World::World(const WorldSettings& settings) {
    assert(validate(settings) && "settings from outside go through validate() first");
    impl_ = std::make_unique<Impl>(settings);
}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

const WorldSettings& World::settings() const {
    return impl_->settings;
}

Result<BodyId> World::add_body(const BodyDesc& desc) {
    const auto added = impl_->add(1, [&](size_t, BodyDesc&) -> const BodyDesc& { return desc; });
    if (!added) return added.error();
    return added->front();
}

Result<std::vector<BodyId>> World::add_bodies(std::span<const BodyDesc> descs) {
    return impl_->add(descs.size(), [&](size_t i, BodyDesc&) -> const BodyDesc& { return descs[i]; });
}

Result<std::vector<BodyId>> World::add_bodies(size_t count, const std::function<BodyDesc(size_t)>& describe) {
    return impl_->add(count, [&](size_t i, BodyDesc& storage) -> const BodyDesc& { return storage = describe(i); });
}

uint32_t World::new_siblings() {
    return ++impl_->last_siblings;
}

bool World::remove_body(BodyId id) {
    const std::optional<size_t> index = impl_->find(id);
    if (!index) return false;
    for (const JointId joint : joints_of(id)) remove_joint(joint);
    impl_->engine->remove(*index);
    const auto at = static_cast<std::ptrdiff_t>(*index);
    impl_->ids.erase(impl_->ids.begin() + at);
    impl_->moved_steps.erase(impl_->moved_steps.begin() + at);
    impl_->previous.erase(impl_->previous.begin() + at);
    ++impl_->removed;
    return true;
}

Result<JointId> World::add_joint(const JointDesc& desc) {
    const JointId id{impl_->next_joint};
    const auto refused = [&](const std::string& fault) {
        return fracture::Error{fracture::Status::invalid_setting, text(id, " cannot be added: ", fault)};
    };
    if (!contains(desc.a)) return refused(text("its a, ", desc.a, ", is not in the world"));
    if (desc.b != BodyId{} && !contains(desc.b)) return refused(text("its b, ", desc.b, ", is not in the world"));
    if (desc.a == desc.b) return refused(text("its a and b are both ", desc.a, "; leave b out for the world"));
    if (const std::string fault = fault_of(desc); !fault.empty()) return refused(fault);
    const bool fixed = desc.kind == JointKind::fixed, distance = desc.kind == JointKind::distance;
    const glm::vec3 axis = fixed || desc.kind == JointKind::hinge ? glm::normalize(desc.axis) : glm::vec3(0.0f);
    const glm::vec3 other = std::abs(axis.x) < 0.6f ? glm::vec3(1.0f, 0.0f, 0.0f) : glm::vec3(0.0f, 1.0f, 0.0f);
    const glm::vec3 up = fixed ? glm::normalize(glm::cross(axis, other)) : glm::vec3(0.0f);
    ++impl_->next_joint;
    impl_->insert(id, {.kind = desc.kind,
                       .a = impl_->side_of(desc.a, desc.anchor_a, axis, up),
                       .b = impl_->side_of(desc.b, distance ? desc.anchor_b : desc.anchor_a, axis, up),
                       .min_length = desc.min_length,
                       .max_length = desc.max_length,
                       .max_force = desc.max_force,
                       .max_torque = desc.max_torque,
                       .bears_pressure = desc.bears_pressure,
                       .collide = desc.collide});
    return id;
}

bool World::remove_joint(JointId id) {
    const std::optional<size_t> index = impl_->find(id);
    if (!index) return false;
    impl_->engine->remove_joint(id);
    impl_->erase(*index);
    return true;
}

bool World::has_joint(JointId id) const {
    return impl_->find(id).has_value();
}
std::span<const JointId> World::joints() const {
    return impl_->joint_ids;
}

std::vector<JointId> World::joints_of(BodyId body) const {
    std::vector<JointId> found;
    for (size_t i = 0; i < impl_->joints.size(); ++i)
        if (impl_->joints[i].a.body == body || impl_->joints[i].b.body == body) found.push_back(impl_->joint_ids[i]);
    return found;
}

const Joint& World::joint(JointId id) const {
    return impl_->joint(id);
}

glm::vec3 World::joint_anchor(JointId id, bool second) const {
    const Joint& joint = impl_->joint(id);
    return impl_->anchor_of(second ? joint.b : joint.a);
}

float World::joint_force(JointId id) const {
    assert(has_joint(id) && "no such joint in this world");
    return impl_->engine->joint_force(id);
}

std::span<const JointId> World::broken_joints() const {
    return impl_->engine->broken_joints();
}

std::vector<LooseJoint> World::take_joints(BodyId body) {
    std::vector<LooseJoint> taken;
    for (const JointId id : joints_of(body)) {
        const Joint& joint = impl_->joint(id);
        const bool second = joint.b.body == body;
        const JointSide& side = second ? joint.b : joint.a;
        const glm::quat turn = impl_->frame_of(side).orientation;
        taken.push_back({id, joint, second, impl_->anchor_of(side), turn * side.axis, turn * side.up});
        remove_joint(id);
    }
    return taken;
}

bool World::put_joint(const LooseJoint& loose, BodyId piece) {
    Joint joint = loose.joint;
    const BodyId other = (loose.second ? joint.a : joint.b).body;
    if (!contains(piece) || other == piece || (other != BodyId{} && !contains(other))) return false;
    (loose.second ? joint.b : joint.a) = impl_->side_of(piece, loose.anchor, loose.axis, loose.up);
    impl_->insert(loose.id, joint);
    return true;
}

void World::clear() {
    clear(WorldSettings(impl_->settings));
}

void World::clear(const WorldSettings& settings) {
    assert(validate(settings) && "settings from outside go through validate() first");
    impl_->settings = settings;
    impl_->engine = make_engine(settings);
    impl_->removed += impl_->ids.size();
    impl_->ids.clear();
    impl_->moved_steps.clear();
    impl_->previous.clear();
    impl_->joint_ids.clear();
    impl_->joints.clear();
    impl_->pending_seconds = 0.0;
    impl_->steps = 0;
}

size_t World::body_count() const {
    return impl_->ids.size();
}
uint64_t World::removed_count() const {
    return impl_->removed;
}
bool World::contains(BodyId id) const {
    return impl_->find(id).has_value();
}
std::span<const BodyId> World::bodies() const {
    return impl_->ids;
}
uint64_t World::steps_taken() const {
    return impl_->steps;
}

void World::step() {
    impl_->engine->write_poses(impl_->moved_steps, impl_->steps,
                               impl_->previous); // poses of other bodies are unchanged
    impl_->engine->step();
    ++impl_->steps;
    for (const JointId broken : impl_->engine->broken_joints()) impl_->erase(*impl_->find(broken));
    const std::span<const uint8_t> moved = impl_->engine->moved();
    for (size_t i = 0; i < moved.size(); ++i)
        if (moved[i] != 0) impl_->moved_steps[i] = impl_->steps;
}

float World::advance(double seconds, const std::function<void()>& after_step) {
    const double step_seconds = impl_->settings.step;
    if (std::isfinite(seconds) && seconds > 0.0) impl_->pending_seconds += seconds;
    for (uint32_t taken = 0; taken < impl_->settings.max_substeps && impl_->pending_seconds >= step_seconds; ++taken) {
        step();
        if (after_step) after_step();
        impl_->pending_seconds -= step_seconds;
    }
    // Drops the remaining time, which would otherwise grow from frame to frame: a slow machine gets slow motion instead
    // of a standstill.
    if (impl_->pending_seconds >= step_seconds)
        impl_->pending_seconds = std::fmod(impl_->pending_seconds, step_seconds);
    return static_cast<float>(impl_->pending_seconds / step_seconds);
}

void World::visit_poses(float alpha, uint64_t since, const PoseVisitor& visit) const {
    for (size_t i = 0; i < impl_->ids.size(); ++i)
        if (impl_->moved_steps[i] >= since) visit(i, impl_->interpolated_pose(i, alpha));
}

uint64_t World::last_moved_step(BodyId id) const {
    return impl_->moved_steps[impl_->index_of(id)];
}

Pose World::pose(BodyId id) const {
    return impl_->engine->pose(impl_->index_of(id));
}
Pose World::previous_pose(BodyId id) const {
    return impl_->previous[impl_->index_of(id)];
}
Pose World::interpolated_pose(BodyId id, float alpha) const {
    return impl_->interpolated_pose(impl_->index_of(id), alpha);
}
glm::vec3 World::linear_velocity(BodyId id) const {
    return impl_->engine->linear_velocity(impl_->index_of(id));
}
glm::vec3 World::angular_velocity(BodyId id) const {
    return impl_->engine->angular_velocity(impl_->index_of(id));
}
float World::mass(BodyId id) const {
    return impl_->engine->mass(impl_->index_of(id));
}
bool World::fixed(BodyId id) const {
    return impl_->engine->fixed(impl_->index_of(id));
}
bool World::debris(BodyId id) const {
    return impl_->engine->debris(impl_->index_of(id));
}
bool World::awake(BodyId id) const {
    return impl_->engine->awake(impl_->index_of(id));
}
Mechanics World::mechanics(BodyId id) const {
    return impl_->engine->mechanics(impl_->index_of(id));
}

void World::apply_impulse(BodyId id, glm::vec3 impulse, glm::vec3 point) {
    const size_t body = impl_->index_of(id);
    assert(finite(impulse) && finite(point));
    if (impl_->engine->fixed(body)) return;
    // A push on a grain of dust, or at a point far from its body.
    const glm::dvec3 arm = glm::dvec3(point) - glm::dvec3(impl_->engine->pose(body).position);
    const glm::dvec3 linear = glm::dvec3(impulse) / static_cast<double>(impl_->engine->mass(body));
    const glm::dvec3 angular = glm::dmat3(impl_->engine->inverse_inertia(body)) * glm::cross(arm, glm::dvec3(impulse));
    const double change = std::max(glm::length(linear), glm::length(angular));
    if (change > static_cast<double>(max_magnitude))
        impulse *= static_cast<float>(static_cast<double>(max_magnitude) / change);
    impl_->engine->apply_impulse(body, impulse, point);
}

void World::set_velocity(BodyId id, glm::vec3 linear, glm::vec3 angular) {
    const size_t body = impl_->index_of(id);
    assert(finite(linear) && finite(angular));
    if (!impl_->engine->fixed(body)) impl_->engine->set_velocity(body, linear, angular);
}

float World::rewind(BodyId id) {
    const size_t body = impl_->index_of(id);
    if (!impl_->engine->fixed(body)) return impl_->engine->rewind(body);
    return impl_->moved_steps[body] < impl_->steps ? impl_->settings.step
                                                   : 0.0f; // or 0 for a body added after the step
}

BodyId World::stopped_by(BodyId id) const {
    const size_t body = impl_->index_of(id);
    return impl_->engine->fixed(body) ? BodyId{} : impl_->engine->stopped_by(body);
}

void World::move_on(BodyId id, float seconds) {
    const size_t body = impl_->index_of(id);
    if (impl_->engine->fixed(body)) return;
    impl_->engine->move_on(body, seconds);
    impl_->moved_steps[body] = impl_->steps;
}

void World::amend_contact(size_t index, const Contact& contact) {
    impl_->engine->amend_contact(index, contact);
}

std::vector<CastHit> World::cast(BodyId id, BodyId target, float seconds) const {
    return impl_->engine->cast(impl_->index_of(id), impl_->index_of(target), seconds);
}

std::optional<RayHit> World::cast_ray(const Ray& ray) const {
    std::optional<RayHit> hit;
    cast_rays({&ray, 1}, {&hit, 1});
    return hit;
}

void World::cast_rays(std::span<const Ray> rays, std::span<std::optional<RayHit>> hits) const {
    assert(rays.size() == hits.size());
    std::fill(hits.begin(), hits.end(), std::nullopt);
    impl_->engine->cast_rays(rays, hits);
    if (!impl_->settings.ground_height) return;
    const auto ground = static_cast<double>(*impl_->settings.ground_height);
    for (size_t i = 0; i < rays.size(); ++i) {
        const glm::dvec3 from(rays[i].from), along = glm::dvec3(rays[i].to) - from;
        if (!can_be_cast(rays[i]) || !(from.y > ground) || !(from.y + along.y <= ground)) continue;
        const double share = (from.y - ground) / -along.y;
        if (hits[i] && static_cast<double>(hits[i]->share) <= share) continue;
        const glm::dvec3 point = from + share * along;
        hits[i] =
            RayHit{.share = static_cast<float>(share),
                   .point = {static_cast<float>(point.x), static_cast<float>(ground), static_cast<float>(point.z)},
                   .normal = {0.0f, 1.0f, 0.0f}};
    }
}

float World::response(BodyId id, glm::vec3 point, glm::vec3 direction) const {
    const size_t body = impl_->index_of(id);
    return impl_->engine->fixed(body) ? 0.0f : impl_->engine->response(body, point, direction);
}

glm::mat3 World::inverse_inertia(BodyId id) const {
    const size_t body = impl_->index_of(id);
    return impl_->engine->fixed(body) ? glm::mat3(0.0f) : impl_->engine->inverse_inertia(body);
}

std::span<const Contact> World::contacts() const {
    return impl_->engine->contacts();
}
std::span<const Contact> World::solved_contacts() const {
    return impl_->engine->solved_contacts();
}

void World::wake_all() {
    for (size_t i = 0; i < impl_->ids.size(); ++i)
        if (!impl_->engine->fixed(i)) impl_->engine->wake(i);
}

Mechanics World::mechanics() const {
    Mechanics sum;
    for (size_t i = 0; i < impl_->ids.size(); ++i) {
        const Mechanics one = impl_->engine->mechanics(i);
        sum.kinetic += one.kinetic;
        sum.potential += one.potential;
        sum.momentum += one.momentum;
        sum.angular_momentum += one.angular_momentum;
    }
    return sum;
}

size_t World::awake_count() const {
    const AwakeCount awake = impl_->engine->awake_count();
    return awake.colliding + awake.debris;
}

size_t World::colliding_count() const {
    return impl_->engine->awake_count().colliding;
}

size_t World::contact_count() const {
    return impl_->engine->contact_count();
}

uint64_t World::state_hash() const {
    StateHash hash;
    impl_->engine->add_state(hash);
    return hash.value();
}

void World::debug_lines(std::vector<DebugLine>& out, const DebugDraw& draw) const {
    impl_->engine->debug_lines(out, draw);
}

} // namespace brittle::physics
