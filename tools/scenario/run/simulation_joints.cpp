// The joints of a simulation: which bodies they connect, and chains of balls.
#include "tools/scenario/run/simulation.h"

#include <limits>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/mesh/nearest.h"
#include "fracture/shapes/shapes.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/run/scene_glue.h"

namespace brittle::tools {

namespace {

using physics::BodyId;

constexpr double link_density = 7800.0; // kg/m^3; steel
// Vertices of the ball of a link: one of a hundred in a chain needs fewer than a shot.
constexpr int link_detail = 0;

} // namespace

physics::BodyId Simulation::add_ball(const glm::dvec3& at, const glm::dvec3& velocity, double radius, double density,
                                     int detail) {
    // A ball of few, evenly spread vertices. A hull of vertices selected from a finer ball has flat spots, which make
    // it spin on impact.
    const fracture::TriangleMesh ball = fracture::icosphere(detail, radius);
    const double mass = density * 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
    const auto inertia = static_cast<float>(0.4 * mass * radius * radius);
    balls_.push_back(
        {must(world_.add_body({.hull = physics::collision_hull(ball.positions, glm::dvec3(0.0), {.max_vertices = 64}),
                               .mass = static_cast<float>(mass),
                               .inertia = glm::mat3(inertia),
                               .pose = {.position = glm::vec3(at)},
                               .linear_velocity = glm::vec3(velocity)})),
         static_cast<float>(radius)});
    return balls_.back().body;
}

// The piece, of a body other than `not_of`, whose convex hull is nearest to a point; the first of equally near ones.
std::optional<uint32_t> Simulation::nearest_piece(std::span<const PreparedObject> objects, const glm::dvec3& at,
                                                  BodyId not_of) const {
    std::optional<uint32_t> nearest;
    double least = std::numeric_limits<double>::infinity();
    std::vector<glm::vec3> points; // near the origin single precision is exact enough
    uint32_t piece = 0;
    const auto compare = [&](std::span<const glm::dvec3> positions, const glm::dvec3& from) {
        const uint32_t own = piece++;
        if (body_of(own) == not_of || body_of(own) == BodyId{}) return;
        points.clear();
        for (const glm::dvec3& position : positions) points.emplace_back(position - from);
        const double distance = fracture::distance_to_hull(points, glm::dvec3(0.0));
        if (!(distance < least)) return;
        least = distance;
        nearest = own;
    };
    for (const PreparedObject& object : objects) {
        const glm::dvec3 from = glm::conjugate(glm::dquat(object.placement.orientation))
                                * (at - glm::dvec3(object.placement.position)); // in the object's coordinates
        if (object.fixed()) {
            compare(object.surface->positions, from);
            continue;
        }
        for (const fracture::Piece& part : object.fragments->pieces)
            compare(object.fragments->positions_of(part), from);
    }
    return nearest;
}

// Joints of glue, in the order of the objects.
void Simulation::start_glue(std::span<const PreparedObject> objects) {
    std::vector<uint32_t> first; // piece, by object
    uint32_t count = 0;
    for (const PreparedObject& object : objects) {
        first.push_back(count);
        count += object.fixed() ? 1 : static_cast<uint32_t>(object.fragments->pieces.size());
    }
    for (uint32_t k = 0; k < objects.size(); ++k)
        for (const PreparedGlue& contact : objects[k].glue) {
            if (!contact.by_joint) continue;
            const BodyId a = body_of(first[k] + contact.piece), b = body_of(first[contact.other] + contact.other_piece);
            (void)must(world_.add_joint(glue_joint(objects, objects[k], contact, a, b)));
        }
}

void Simulation::start_joints(std::span<const PreparedObject> objects, const WorldOptions& options) {
    start_glue(objects);
    const glm::dvec3 foot(0.0, foot_height(options), 0.0);
    for (size_t i = 0; i < options.joints.size(); ++i) {
        PlacedJoint joint{.options = options.joints[i]};
        joint.options.at += foot;
        joint.options.to += foot;
        const auto body = [&](std::optional<uint32_t> piece) { return piece ? body_of(*piece) : BodyId{}; };
        if (!joint.options.shot) joint.a = nearest_piece(objects, joint.options.at, {});
        const bool distance = joint.options.kind == physics::JointKind::distance;
        if (joint.options.to_piece) {
            joint.b = nearest_piece(objects, distance ? joint.options.to : joint.options.at, body(joint.a));
            if (!joint.b)
                throw Failure{exit_input, "world/joints/" + std::to_string(i)
                                              + ": there is no second body to join; leave to_piece out for the world"};
        }
        if (joint.options.shot)
            shot_joints_.push_back(joint);
        else
            join(joint, body(joint.a));
    }
}

// Joins the other side, unless it is a piece that is gone by now.
void Simulation::join(const PlacedJoint& joint, BodyId a) {
    const JointOptions& options = joint.options;
    const BodyId b = joint.b ? body_of(*joint.b) : BodyId{};
    if (joint.b && b == BodyId{}) return;
    physics::JointDesc desc{.kind = options.kind,
                            .a = a,
                            .b = b,
                            .anchor_a = glm::vec3(options.at),
                            .anchor_b = glm::vec3(options.to),
                            .axis = glm::vec3(options.axis)};
    if (options.max_force > 0.0) desc.max_force = static_cast<float>(options.max_force);
    if (options.max_torque > 0.0) desc.max_torque = static_cast<float>(options.max_torque);
    if (options.kind != physics::JointKind::distance) {
        (void)must(world_.add_joint(desc));
        return;
    }
    const glm::dvec3 way = options.to - options.at;
    if (options.links == 0) {
        desc.max_length = static_cast<float>(options.max_length.value_or(std::max(glm::length(way), 0.001)));
        desc.min_length = std::min(static_cast<float>(options.min_length), desc.max_length);
        (void)must(world_.add_joint(desc));
        return;
    }
    // Links with a joint at each end, which the solver keeps still under any tension; ropes between balls tremble.
    desc.kind = physics::JointKind::ball;
    for (uint32_t link = 0; link < options.links; ++link) {
        const glm::dvec3 middle = options.at + way * ((link + 0.5) / options.links);
        desc.b = add_ball(middle, glm::dvec3(0.0), options.link_radius, link_density, link_detail);
        (void)must(world_.add_joint(desc));
        desc.a = desc.b;
        desc.anchor_a = glm::vec3(options.at + way * ((link + 1.0) / options.links));
    }
    desc.b = b;
    (void)must(world_.add_joint(desc));
}

// Joins the ball that was shot last.
void Simulation::join_shot(const glm::dvec3& at) {
    const BodyId ball = balls_.back().body;
    const uint32_t number = shots_++;
    for (PlacedJoint joint : shot_joints_) {
        if (joint.options.shot != number) continue;
        if (joint.options.kind == physics::JointKind::distance) joint.options.at = at;
        // A chain hangs from the ball's surface, so that no link lies inside the ball and collides with it.
        const glm::dvec3 way = joint.options.to - joint.options.at;
        const auto radius = static_cast<double>(balls_.back().radius);
        if (joint.options.links > 0 && glm::length(way) > radius) joint.options.at += radius * glm::normalize(way);
        join(joint, ball);
    }
}

} // namespace brittle::tools
