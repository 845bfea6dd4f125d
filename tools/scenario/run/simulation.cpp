#include "tools/scenario/run/simulation.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "engine/camera/sun.h"
#include "engine/camera/view_volume.h"
#include "fracture/mesh/mass_properties.h"
#include "physics/bonds/anchor.h"
#include "physics/world/pieces.h"
#include "physics/world/state_hash.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/run/scene_glue.h"

namespace brittle::tools {

namespace {

using physics::BodyId;
using physics::Pose;

// A grabbed point moves to the hand at grab_rate times its distance, within grab_acceleration; grab_damping stops the
// piece from swinging.
constexpr float grab_rate = 10.0f;          // 1/s, approach speed by distance; higher is stiffer
constexpr float grab_acceleration = 150.0f; // m/s^2, limit; below it, pieces that hang from a fast hand are lost
constexpr float grab_damping = 4.0f;        // 1/s, of angular velocity

constexpr int shot_detail = 1;                             // subdivisions of the icosahedron of a ball that is shot
[[maybe_unused]] constexpr size_t any_number = UINT32_MAX; // accepts numbers of pieces that do not exist yet

double hammer_energy(double impulse) {
    return 0.5 * impulse * impulse / hammer_mass;
}

// N. A hammer of one kilogram stops within impact_seconds.
double hammer_force(double impulse) {
    static_assert(hammer_mass == 1.0);
    return impulse / static_cast<double>(physics::impact_seconds);
}

} // namespace

Simulation::Simulation(const std::string& material, DrawingMaker payload)
    : material_(physics::material_preset(material)), payload_(std::move(payload)) {}

void Simulation::commit_as(physics::Timing timing, std::vector<physics::Commit> script) {
    timing_ = timing;
    script_ = std::move(script);
}

void Simulation::clear() {
    world_.clear();
    structure_.reset();
    loose_.clear();
    destruction_.reset();
    members_.clear();
    first_objects_.clear();
    balls_.clear();
    scheduled_.clear();
    grabbed_.reset();
    shot_joints_.clear();
    shots_ = 0;
    pieces_ = 0;
}

void Simulation::start(const fracture::Fragments& fragments, const WorldOptions& options) {
    PreparedObject object{.fragments = {std::shared_ptr<const fracture::Fragments>(), &fragments},
                          .world = options,
                          .material = std::string(material_ ? material_->name : "")};
    prepare(object, payload_);
    start(std::move(object));
}

void Simulation::start_world(const WorldOptions& options) {
    clear();
    physics::WorldSettings settings = world_.settings();
    settings.engine = options.engine;
    settings.air_density = static_cast<float>(options.air_density);
    settings.max_colliding = options.max_colliding;
    world_.clear(settings);
}

// An object that never breaks needs no destruction.
void Simulation::start(PreparedObject object) {
    const WorldOptions options = object.world;
    if (object.world.breakable) {
        std::vector<PreparedObject> objects;
        objects.push_back(std::move(object));
        return start(std::move(objects), options);
    }
    start_world(options);
    members_.push_back({object.name, material_});
    if (holds_together(options)) {
        physics::StructureDesc desc = structure_desc(object);
        desc.hulls = std::move(object.bodies.hulls);
        structure_ = must(physics::Structure::create(world_, *object.fragments, desc));
    } else {
        loose_ =
            must(physics::add_pieces(world_, *object.fragments, plain_material(material_), {}, object.bodies.hulls));
    }
    pieces_ = object.fragments->pieces.size();
    run_from({&object, 1}, options);
}

void Simulation::start(std::vector<PreparedObject> objects, const WorldOptions& world) {
    start_world(world);
    destruction_.emplace(physics::DestructionSettings{.timing = timing_, .debris = {.max_pieces = world.piece_limit}});
    destruction_->follow(script_);
    std::map<uint32_t, std::vector<uint32_t>> groups = glued_groups(objects);
    std::map<uint32_t, GluedPart> glued; // by object
    for (uint32_t k = 0; k < objects.size(); ++k) {
        PreparedObject& object = objects[k];
        try {
            if (const auto group = groups.find(k); group != groups.end()) assemble(objects, group->second, glued);
            const auto part = glued.find(k);
            add_breakable(object, part == glued.end() ? nullptr : &part->second);
        } catch (const Failure& failure) {
            if (object.name.empty()) throw;
            throw failure.at(object.name);
        }
    }
    pieces_ = destruction_->pieces().size();
    run_from(objects, world);
}

void Simulation::run_from(std::span<const PreparedObject> objects, const WorldOptions& options) {
    start_joints(objects, options);
    if (observer_) observer_->started(*this, objects, options);
    for (const Shot& shot : options.shots)
        schedule(static_cast<uint64_t>(std::llround(shot.time / static_cast<double>(world_.settings().step))),
                 Shoot{shot.from, shot.velocity, shot.radius, shot.density});
}

// Makes the structure of objects that are glued to each other. The other side of glue to a fixed object is a support.
void Simulation::assemble(std::span<const PreparedObject> objects, std::span<const uint32_t> group,
                          std::map<uint32_t, GluedPart>& glued) {
    std::vector<physics::AssemblyPart> parts;
    std::vector<physics::GlueBond> bonds;
    std::map<uint32_t, uint32_t> part_of;
    for (const uint32_t k : group) {
        const PreparedObject& object = objects[k];
        part_of[k] = static_cast<uint32_t>(parts.size());
        physics::AssemblyPart& part = parts.emplace_back();
        part.fragments = object.fragments.get();
        part.desc = structure_desc(object);
        for (const physics::SolidPtr& solid : object.bodies.solids) part.desc.piece_parts.push_back(solid->parts);
        for (const PreparedGlue& contact : object.glue) {
            const PreparedObject& other = objects[contact.other];
            physics::GlueBond& bond = bonds.emplace_back();
            bond.a = {part_of[k], contact.piece};
            bond.area = contact.area;
            bond.centroid = contact.centroid;
            bond.normal = contact.normal;
            bond.strength = contact.strength;
            if (!other.fixed())
                bond.b = physics::GlueBond::Side{part_of.at(contact.other), contact.other_piece};
            else if (!other.material.empty())
                bond.fixed_material = flawed_material(other);
        }
    }
    const physics::AssemblyId assembly = must(destruction_->assemble(world_, parts, bonds));
    for (const uint32_t k : group) glued[k] = {assembly, part_of[k]};
}

void Simulation::add_breakable(PreparedObject& object, const GluedPart* glued) {
    const physics::BreakableDesc desc = breakable_desc(object, payload_);
    std::vector<physics::PayloadPtr>& payloads = object.bodies.payloads;
    members_.push_back({object.name, physics::material_preset(object.material), object.placement, object.fixed()});
    std::optional<physics::ObjectId> first;
    if (glued) {
        first =
            destruction_->add(world_, glued->assembly, glued->part, desc, object.bodies.solids, std::move(payloads));
    } else if (object.world.bonded) {
        first = must(destruction_->add(world_, *object.fragments, structure_desc(object), desc, object.bodies.solids,
                                       std::move(payloads)));
    } else {
        for (size_t i = 0; i < object.bodies.solids.size(); ++i) {
            const physics::ObjectId added =
                must(destruction_->add(world_, object.bodies.solids[i], desc, std::move(payloads[i])));
            if (!first) first = added;
        }
    }
    first_objects_.push_back(first.value_or(physics::ObjectId{}));
}

uint32_t Simulation::member_of(uint32_t piece) const {
    return destruction_ ? member_of(destruction_->object({piece})) : 0;
}

uint32_t Simulation::member_of(physics::ObjectId object) const {
    const auto after = std::ranges::upper_bound(first_objects_, object);
    return static_cast<uint32_t>(after - first_objects_.begin()) - 1;
}

void Simulation::apply(const Action& action) {
    assert(fault_of(action, destruction_ ? any_number : pieces_).empty());
    std::visit([this](const auto& one) { act(one); }, action);
    if (observer_) observer_->acted(steps(), action);
}

void Simulation::schedule(uint64_t step, const Action& action) {
    if (step <= steps()) return apply(action);
    const auto later = std::upper_bound(scheduled_.begin(), scheduled_.end(), step,
                                        [](uint64_t value, const auto& entry) { return value < entry.first; });
    scheduled_.insert(later, {step, action});
}

void Simulation::apply_due() {
    while (!scheduled_.empty() && scheduled_.front().first <= steps()) {
        const Action action = std::move(scheduled_.front().second);
        scheduled_.erase(scheduled_.begin());
        apply(action);
    }
}

void Simulation::step() {
    world_.step();
    after_step();
}

float Simulation::advance(double seconds) {
    return world_.advance(seconds, [this] { after_step(); });
}

void Simulation::after_step() {
    if (observer_) observer_->moved(*this);
    if (destruction_) {
        destruction_->update(world_);
        if (observer_) observer_->updated(*this, {});
    }
    if (structure_) {
        const physics::Structure::Changes& changes = structure_->update(world_);
        if (observer_) observer_->updated(*this, changes);
    }
    pull_grabbed();
    if (observer_) observer_->stepped(*this);
    apply_due();
}

void Simulation::visit_poses(float alpha, uint64_t since, const PoseVisitor& visit) const {
    if (destruction_) return destruction_->visit_poses(world_, alpha, since, visit);
    if (structure_) return structure_->visit_poses(world_, alpha, since, visit);
    for (uint32_t piece = 0; piece < loose_.size(); ++piece)
        if (world_.contains(loose_[piece]) && world_.last_moved_step(loose_[piece]) >= since)
            visit(piece, world_.interpolated_pose(loose_[piece], alpha));
}

uint64_t Simulation::state_hash() const {
    physics::StateHash hash;
    hash.add(world_.state_hash());
    for (const physics::JointId joint : world_.joints()) hash.add(joint.value);
    if (structure_) hash.add(structure_->state_hash());
    if (destruction_) hash.add(destruction_->state_hash());
    return hash.value();
}

physics::DestructionEvents Simulation::take_events() {
    return destruction_ ? destruction_->take_events() : physics::DestructionEvents{};
}

std::span<const physics::Commit> Simulation::commits() const {
    return destruction_ ? destruction_->commits() : std::span<const physics::Commit>{};
}

uint32_t Simulation::number_count() const {
    return destruction_ ? destruction_->next_piece().value : static_cast<uint32_t>(pieces_);
}

template<class Self>
auto Simulation::structures_of(Self& self) -> std::vector<decltype(&*self.structure_)> {
    std::vector<decltype(&*self.structure_)> found;
    if (self.structure_) found.push_back(&*self.structure_);
    if (self.destruction_)
        for (auto* structure : self.destruction_->structures()) found.push_back(structure);
    return found;
}

template<class Self>
auto Simulation::structure_of(Self& self, uint32_t piece) -> decltype(&*self.structure_) {
    if (self.structure_) return &*self.structure_;
    if (!self.destruction_ || !self.destruction_->contains({piece}) || !self.destruction_->bonded({piece}))
        return nullptr;
    return self.destruction_->structure(self.destruction_->object({piece}));
}

uint32_t Simulation::index_in_structure(uint32_t piece) const {
    return structure_ ? piece : *destruction_->bonded({piece});
}

std::vector<const physics::Structure*> Simulation::structures() const {
    return structures_of(*this);
}

std::pair<const physics::Structure*, uint32_t> Simulation::bonds_of(uint32_t piece) const {
    const physics::Structure* const structure = structure_of(*this, piece);
    return {structure, structure ? index_in_structure(piece) : 0};
}

const physics::Structure* Simulation::structure() const {
    const std::vector<const physics::Structure*> all = structures();
    return all.empty() ? nullptr : all.front();
}

BodyId Simulation::body_of(uint32_t piece) const {
    BodyId body;
    if (destruction_) {
        if (destruction_->contains({piece})) body = destruction_->body({piece});
    } else if (piece < pieces_) {
        body = structure_ ? structure_->body_of(piece) : loose_[piece];
    }
    return world_.contains(body) ? body : BodyId{};
}

std::vector<uint32_t> Simulation::pieces_of(BodyId body) const {
    std::vector<uint32_t> pieces;
    for (uint32_t piece = 0; piece < number_count(); ++piece)
        if (body_of(piece) == body) pieces.push_back(piece);
    return pieces;
}

Pose Simulation::pose_of(uint32_t piece) const {
    if (destruction_) return destruction_->pose(world_, {piece});
    Pose pose = world_.pose(body_of(piece));
    if (structure_) pose.position += pose.orientation * structure_->offset(piece);
    return pose;
}

void Simulation::act(const Shoot& shot) {
    add_ball(shot.from, shot.velocity, shot.radius, shot.density, shot_detail);
    join_shot(shot.from);
}

void Simulation::act(const Damage& damage) {
    for (physics::Structure* structure : structures_of(*this))
        structure->damage(world_, glm::vec3(damage.point), static_cast<float>(damage.radius),
                          static_cast<float>(damage.amount));
}

void Simulation::act(const Saw& saw) {
    for (physics::Structure* structure : structures_of(*this))
        structure->damage_segment(world_, glm::vec3(saw.from), glm::vec3(saw.to), static_cast<float>(saw.radius),
                                  static_cast<float>(saw.amount));
}

void Simulation::act(const Hammer& blow) {
    if (body_of(blow.piece) == BodyId{}) return;
    if (physics::Structure* structure = structure_of(*this, blow.piece))
        structure->blow(world_, index_in_structure(blow.piece), glm::vec3(blow.impulse));
    const double impulse = glm::length(blow.impulse);
    if (!destruction_) return;
    destruction_->strike(world_, {blow.piece}, glm::vec3(blow.point), glm::vec3(blow.impulse / impulse),
                         hammer_energy(impulse), hammer_force(impulse));
}

std::optional<physics::PlannedCut> Simulation::foresee(const Hammer& blow) const {
    const double impulse = glm::length(blow.impulse);
    if (!destruction_ || body_of(blow.piece) == BodyId{}) return std::nullopt;
    return destruction_->foresee(world_, {blow.piece}, glm::vec3(blow.point), glm::vec3(blow.impulse / impulse),
                                 hammer_energy(impulse), hammer_force(impulse));
}

void Simulation::act(const Release& release) {
    std::vector<uint32_t> pieces = release.pieces;
    for (uint32_t piece = 0; release.pieces.empty() && piece < pieces_; ++piece) pieces.push_back(piece);
    for (physics::Structure* structure : structures_of(*this)) {
        std::vector<uint32_t> own;
        for (const uint32_t piece : pieces)
            if (structure_of(*this, piece) == structure) own.push_back(index_in_structure(piece));
        structure->release_anchors(own);
    }
}

void Simulation::act(const Push& push) {
    const BodyId body = body_of(push.piece);
    if (body != BodyId{}) world_.apply_impulse(body, glm::vec3(push.impulse), glm::vec3(push.point));
}

void Simulation::act(const Grab& grab) {
    grabbed_.reset();
    if (body_of(grab.piece) == BodyId{}) return;
    const Pose pose = pose_of(grab.piece);
    const glm::dvec3 arm = grab.point - glm::dvec3(pose.position);
    grabbed_ = Grabbed{grab.piece, glm::conjugate(glm::dquat(pose.orientation)) * arm, grab.point};
}

void Simulation::act(const Drag& drag) {
    if (grabbed_) grabbed_->to = drag.to;
}

void Simulation::act(const LetGo&) {
    grabbed_.reset();
}

// A piece is also visible by its shadow: the test covers the way from the piece to its shadow on the ground.
void Simulation::act(const Watch& watch) {
    if (!destruction_) return;
    const engine::ViewVolume view(
        {.eye = glm::vec3(watch.eye), .target = glm::vec3(watch.target), .vertical_fov = static_cast<float>(watch.fov)},
        static_cast<float>(watch.aspect));
    const glm::vec3 to_light = engine::default_to_light;
    destruction_->set_view([view, to_light](const glm::vec3& centre, float radius) {
        const glm::vec3 shadow = centre - std::max(centre.y, 0.0f) / to_light.y * to_light;
        return view.sees(centre, shadow, radius);
    });
}

// Applies the impulse that gives the grabbed point its target velocity, by the effective mass at that point. So it
// never overshoots, however light the body is and wherever it is grabbed.
void Simulation::pull_grabbed() {
    if (!grabbed_) return;
    const BodyId body = body_of(grabbed_->piece);
    if (body == BodyId{}) {
        grabbed_.reset();
        return;
    }
    if (world_.fixed(body)) return;
    const Pose pose = pose_of(grabbed_->piece);
    const glm::vec3 arm = pose.orientation * glm::vec3(grabbed_->local);
    const glm::vec3 point = pose.position + arm;
    const glm::vec3 angular = world_.angular_velocity(body);
    const glm::vec3 now = world_.linear_velocity(body) + glm::cross(angular, point - world_.pose(body).position);
    const glm::vec3 change = grab_rate * (glm::vec3(grabbed_->to) - point) - now;
    const float speed = glm::length(change);
    const float step = world_.settings().step;
    world_.set_velocity(body, world_.linear_velocity(body), angular * (1.0f - grab_damping * step));
    if (!(speed > 0.0f)) return;
    const glm::vec3 direction = change / speed;
    const float response = world_.response(body, point, direction);
    if (!(response > 0.0f)) return;
    world_.apply_impulse(body, std::min(speed, grab_acceleration * step) / response * direction, point);
}

} // namespace brittle::tools
