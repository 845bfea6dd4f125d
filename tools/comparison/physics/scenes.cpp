#include "tools/comparison/physics/scenes.h"

#include <array>
#include <cmath>
#include <numbers>

#include <glm/gtc/quaternion.hpp>

#include "fracture/mesh/principal_axes.h"
#include "physics/material.h"
#include "physics/world/body_form.h"
#include "tools/bench/bounds.h"
#include "tools/bench/broken_bunny.h"
#include "tools/bench/scenes.h"

namespace brittle::comparison {

namespace {

constexpr double stack_edge = 1.0, drop_height = 0.3; // m
constexpr uint32_t sites_for_300 = 570;
// Of the trace. Below it, a tensor counts as diagonal: the axes of a cube are otherwise those of rounding errors.
constexpr double diagonal_tensor = 1e-6;

constexpr std::array infos{
    SceneInfo{"stack_20", "20 cubes of 1 m on each other", Outcome::stands, 0.0, tools::stack_fall* stack_edge, 30.0,
              12},
    SceneInfo{"mass_ratio_10", "5 cubes of 1 m under one of 10 times their mass", Outcome::stands, 0.0,
              tools::stack_fall* stack_edge, 30.0, 12},
    SceneInfo{"card_house_4", "a house of cards, 4 levels, friction 0.49", Outcome::stands, 0.0, tools::card_fall, 30.0,
              12},
    SceneInfo{"arch_09", "a stone arch, t/R 0.09", Outcome::falls, 0.09, tools::arch_fall, 10.0, 12},
    SceneInfo{"arch_13", "a stone arch, t/R 0.13", Outcome::stands, 0.13, tools::arch_fall, 30.0, 12},
    SceneInfo{"dominoes", "60 dominoes of 4.8 cm", Outcome::wave, 0.0, 0.0, 3.0, 1},
    SceneInfo{"bounce_50", "a ball falls 1 m, restitution 0.5", Outcome::bounces, 0.5, 0.0, 2.0, 1},
    SceneInfo{"bounce_90", "a ball falls 1 m, restitution 0.9", Outcome::bounces, 0.9, 0.0, 2.0, 1},
    SceneInfo{"slope_below", "a box on a slope, half a degree below the angle of repose", Outcome::rests, -0.5, 0.0,
              6.0, 12},
    SceneInfo{"slope_above", "a box on a slope, half a degree above the angle of repose", Outcome::slides, 0.5, 0.0,
              6.0, 12},
    SceneInfo{"pile_300", "the bunny in 299 pieces, which fall and pile up", Outcome::piles_up, drop_height, 0.0, 10.0,
              12},
    SceneInfo{"heap_1013", "the bunny in 1,013 pieces, which fall and pile up", Outcome::piles_up, drop_height, 0.0,
              5.0, 12}};

Numbers3 numbers_of(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

// A body whose frame is turned to the principal axes.
RigidBody body_of(const physics::BodyDesc& desc, const glm::dmat3& inertia, std::span<const glm::dvec3> corners) {
    const double trace = inertia[0][0] + inertia[1][1] + inertia[2][2];
    const double off = std::max({std::abs(inertia[1][0]), std::abs(inertia[2][0]), std::abs(inertia[2][1])});
    fracture::PrincipalAxes principal{.moments = {inertia[0][0], inertia[1][1], inertia[2][2]}};
    if (off > diagonal_tensor * trace) principal = fracture::principal_axes(inertia);
    const glm::dquat turn =
        glm::normalize(glm::normalize(glm::dquat(desc.pose.orientation)) * glm::quat_cast(principal.axes));
    RigidBody body{.fixed = desc.fixed,
                   .numbers = {.mass = static_cast<double>(desc.mass),
                               .moments = numbers_of(principal.moments),
                               .pose = {numbers_of(glm::dvec3(desc.pose.position)), {turn.x, turn.y, turn.z, turn.w}},
                               .velocity = numbers_of(glm::dvec3(desc.linear_velocity)),
                               .angular_velocity = numbers_of(glm::dvec3(desc.angular_velocity)),
                               .friction = static_cast<double>(desc.friction),
                               .restitution = static_cast<double>(desc.restitution)}};
    for (const glm::dvec3& corner : corners)
        body.corners.push_back(numbers_of(glm::transpose(principal.axes) * corner));
    return body;
}

RigidScene rigid_scene(const physics::WorldSettings& settings) {
    return {.ground = settings.ground_height.has_value(),
            .numbers = {.gravity = numbers_of(glm::dvec3(settings.gravity)),
                        .step = 1.0 / 120.0,
                        .ground_friction = static_cast<double>(settings.ground_friction),
                        .ground_restitution = static_cast<double>(settings.ground_restitution)}};
}

RigidScene rigid_scene(const tools::Scene& scene) {
    RigidScene made = rigid_scene(scene.settings);
    for (size_t k = 0; k < scene.bodies.size(); ++k)
        made.bodies.push_back(body_of(scene.bodies[k], glm::dmat3(scene.bodies[k].inertia), scene.solids[k]));
    return made;
}

// Solids of at most 32 corners that do not overlap: collision hulls whose margin is next to nothing.
RigidScene broken_bunny(uint32_t sites) {
    const tools::BrokenBunny broken(sites);
    const physics::PieceHulls hulls =
        physics::collision_hulls(broken.pieces, {.margin_fraction = 0.001f, .max_margin = 1e-6f});
    const physics::Material material;
    RigidScene scene = rigid_scene(physics::WorldSettings{});
    for (size_t k = 0; k < hulls.size(); ++k) {
        physics::BodyDesc desc;
        desc.mass = broken.forms[k]->mass;
        desc.pose.position = glm::vec3(broken.pieces.pieces[k].mass.centre_of_mass + glm::dvec3(0.0, drop_height, 0.0));
        desc.friction = material.friction;
        desc.restitution = material.restitution;
        const std::vector<glm::dvec3> corners(hulls[k]->points.begin(), hulls[k]->points.end());
        scene.bodies.push_back(body_of(desc, glm::dmat3(broken.forms[k]->inertia), corners));
    }
    return scene;
}

RigidScene scene_of(const SceneInfo& info) {
    const std::string name = info.name;
    switch (info.outcome) {
    case Outcome::stands:
    case Outcome::falls:
        if (name == "stack_20") return rigid_scene(tools::stack(20, stack_edge));
        if (name == "mass_ratio_10") return rigid_scene(tools::loaded_stack(5, stack_edge, 10.0));
        if (name == "card_house_4") return rigid_scene(tools::card_house(4));
        return rigid_scene(tools::arch(info.parameter));
    case Outcome::slides:
    case Outcome::rests:
        return rigid_scene(
            tools::slope(std::atan(slope_friction) + info.parameter * std::numbers::pi / 180.0, slope_friction));
    case Outcome::bounces:
        return rigid_scene(tools::drop(tools::Dropped::ball, info.parameter, false, bounce_height));
    case Outcome::wave:
        return rigid_scene(tools::dominoes({}));
    case Outcome::piles_up:
        return broken_bunny(name == "pile_300" ? sites_for_300 : tools::sites_for_1000);
    }
    throw std::runtime_error("scene " + name + " has no outcome");
}

} // namespace

std::span<const SceneInfo> scene_infos() {
    return infos;
}

const SceneInfo& scene_info(const std::string& name) {
    std::string names;
    for (const SceneInfo& info : infos) {
        if (name == info.name) return info;
        names += std::string(names.empty() ? "" : ", ") + info.name;
    }
    throw std::runtime_error("there is no scene '" + name + "', only " + names);
}

RigidScene make_scene(const SceneInfo& info) {
    RigidScene scene = scene_of(info);
    scene.steps = static_cast<uint32_t>(std::lround(info.seconds / scene.numbers.step));
    scene.steps_a_record = info.steps_a_record;
    return scene;
}

void write_scene(const std::string& file, const RigidScene& scene) {
    write_file(file, scene_magic, [&](const auto& put) {
        const std::array<uint32_t, 4> counts{scene.steps, scene.steps_a_record, scene.ground ? 1u : 0u,
                                             static_cast<uint32_t>(scene.bodies.size())};
        put(counts.data(), sizeof counts);
        put(&scene.numbers, sizeof scene.numbers);
        for (const RigidBody& body : scene.bodies) {
            const std::array<uint32_t, 2> sizes{body.fixed ? 1u : 0u, static_cast<uint32_t>(body.corners.size())};
            put(sizes.data(), sizeof sizes);
            put(&body.numbers, sizeof body.numbers);
            put(body.corners.data(), body.corners.size() * sizeof(Numbers3));
        }
    });
}

} // namespace brittle::comparison
