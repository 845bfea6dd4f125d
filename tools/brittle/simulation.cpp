#include "tools/brittle/simulation.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/mass_properties.h"
#include "fracture/shapes.h"
#include "physics/pieces.h"
#include "tools/brittle/failure.h"

namespace brittle::tools {

namespace {

using physics::BodyId;
using physics::Pose;

// Of the handbook strengths of flawless samples, what things have against blows: at full strength a stone
// arch turns back a ball of a quarter of a ton.
constexpr float flawed = 0.1f;

// What is grabbed comes to the hand with this share of the distance a second, no harder than this, and stops
// to swing.
constexpr float grab_rate = 10.0f;          // 1/s; higher: stiffer
constexpr float grab_acceleration = 150.0f; // m/s^2; less would not hold what hangs from it in a fast hand
constexpr float grab_damping = 4.0f;        // 1/s, of angular velocity

} // namespace

Simulation::Simulation(const std::string& material) : material_(physics::material_preset(material)) {}

void Simulation::clear() {
    world_.clear();
    structure_.reset();
    loose_.clear();
    balls_.clear();
    due_.clear();
    held_.reset();
    pieces_ = 0;
}

void Simulation::start(const fracture::Fragments& fragments, const WorldOptions& options) {
    clear();
    physics::Material material = material_ ? material_->material : physics::Material{};
    if (options.bonded || options.anchored) {
        physics::StructureDesc desc{.material = material};
        for (float* strength : {&desc.material.tensile, &desc.material.compressive, &desc.material.shear})
            *strength *= flawed * static_cast<float>(options.strength);
        desc.wear.strength_scale /= flawed;
        if (options.anchored) desc.anchored = physics::anchor_to_ground(fragments);
        structure_ = must(physics::Structure::create(world_, fragments, desc));
    } else {
        loose_ = must(physics::add_pieces(world_, fragments, material));
    }
    pieces_ = fragments.pieces.size();
    if (observer_) observer_->started(*this, fragments, options);
    for (const Shot& shot : options.shots)
        schedule(static_cast<uint64_t>(std::llround(shot.time / static_cast<double>(world_.settings().step))),
                 Shoot{shot.from, shot.velocity, shot.radius, shot.density});
}

void Simulation::apply(const Action& action) {
    assert(fault_of(action, pieces_).empty());
    std::visit([this](const auto& one) { act(one); }, action);
    if (observer_) observer_->acted(steps(), action);
}

void Simulation::schedule(uint64_t step, const Action& action) {
    if (step <= steps()) return apply(action);
    const auto later =
        std::upper_bound(due_.begin(), due_.end(), step,
                         [](uint64_t value, const auto& entry) { return value < entry.first; });
    due_.insert(later, {step, action});
}

void Simulation::act_when_due() {
    while (!due_.empty() && due_.front().first <= steps()) {
        const Action action = std::move(due_.front().second);
        due_.erase(due_.begin());
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
    if (structure_) {
        const physics::Structure::Changes& changes = structure_->update(world_);
        if (observer_) observer_->updated(*this, changes);
    }
    draw_held();
    if (observer_) observer_->stepped(*this);
    act_when_due();
}

void Simulation::write_poses(std::span<Pose> out, float alpha) const {
    if (structure_)
        structure_->write_piece_transforms(world_, out, alpha);
    else
        world_.write_transforms(out.first(std::min(out.size(), pieces_)), alpha); // pieces come before balls
}

BodyId Simulation::body_of(uint32_t piece) const {
    const BodyId body = structure_ ? structure_->body_of(piece) : loose_[piece];
    return world_.contains(body) ? body : BodyId{};
}

std::vector<uint32_t> Simulation::pieces_of(BodyId body) const {
    std::vector<uint32_t> pieces;
    for (uint32_t piece = 0; piece < pieces_; ++piece)
        if (body_of(piece) == body) pieces.push_back(piece);
    return pieces;
}

Pose Simulation::piece_pose(uint32_t piece) const {
    Pose pose = world_.pose(body_of(piece));
    if (structure_) pose.position += pose.orientation * structure_->offset(piece);
    return pose;
}

void Simulation::act(const Shoot& shot) {
    const fracture::TriangleMesh ball = fracture::icosphere(2, shot.radius);
    const double mass = shot.density * fracture::signed_volume(ball.positions, ball.triangles);
    const auto inertia = static_cast<float>(0.4 * mass * shot.radius * shot.radius);
    balls_.push_back({must(world_.add_body({.hull = physics::collision_hull(ball.positions, glm::dvec3(0.0),
                                                                            {.max_vertices = 64}),
                                            .mass = static_cast<float>(mass),
                                            .inertia = glm::mat3(inertia),
                                            .pose = {.position = glm::vec3(shot.from)},
                                            .linear_velocity = glm::vec3(shot.velocity)})),
                      static_cast<float>(shot.radius)});
}

void Simulation::act(const Damage& damage) {
    if (structure_)
        structure_->damage(world_, glm::vec3(damage.point), static_cast<float>(damage.radius),
                           static_cast<float>(damage.amount));
}

void Simulation::act(const Saw& saw) {
    if (structure_)
        structure_->damage_segment(world_, glm::vec3(saw.from), glm::vec3(saw.to),
                                   static_cast<float>(saw.radius), static_cast<float>(saw.amount));
}

void Simulation::act(const Hammer& hammer) {
    if (structure_ && body_of(hammer.piece) != BodyId{})
        structure_->blow(world_, hammer.piece, glm::vec3(hammer.impulse));
}

void Simulation::act(const Release& release) {
    if (!structure_) return;
    std::vector<uint32_t> pieces = release.pieces;
    for (uint32_t piece = 0; release.pieces.empty() && piece < pieces_; ++piece) pieces.push_back(piece);
    structure_->release_anchors(pieces);
}

void Simulation::act(const Push& push) {
    const BodyId body = body_of(push.piece);
    if (body != BodyId{}) world_.apply_impulse(body, glm::vec3(push.impulse), glm::vec3(push.point));
}

void Simulation::act(const Grab& grab) {
    held_.reset();
    if (body_of(grab.piece) == BodyId{}) return;
    const Pose pose = piece_pose(grab.piece);
    const glm::dvec3 arm = grab.point - glm::dvec3(pose.position);
    held_ = Held{grab.piece, glm::conjugate(glm::dquat(pose.orientation)) * arm, grab.point};
}

void Simulation::act(const Drag& drag) {
    if (held_) held_->to = drag.to;
}

void Simulation::act(const LetGo&) {
    held_.reset();
}

// An impulse that gives the point that is held the speed at which it should come, by the mass that is felt
// there; so it never overshoots, however light or oddly held the body is.
void Simulation::draw_held() {
    if (!held_) return;
    const BodyId body = body_of(held_->piece);
    if (body == BodyId{}) {
        held_.reset();
        return;
    }
    if (world_.fixed(body)) return;
    const Pose pose = piece_pose(held_->piece);
    const glm::vec3 arm = pose.orientation * glm::vec3(held_->local);
    const glm::vec3 point = pose.position + arm;
    const glm::vec3 angular = world_.angular_velocity(body);
    const glm::vec3 now =
        world_.linear_velocity(body) + glm::cross(angular, point - world_.pose(body).position);
    const glm::vec3 change = grab_rate * (glm::vec3(held_->to) - point) - now;
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
