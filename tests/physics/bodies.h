// Bodies and measurements for tests of the world.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "physics/world/hull.h"
#include "physics/world/world.h"

namespace brittle::physics::test_bodies {

inline const WorldSettings empty_space{
    .gravity = {0.0f, 0.0f, 0.0f}, .ground_height = std::nullopt, .air_density = 0.0f, .sleeping = false};

// `half`: half of the sides, m.
inline CollisionHull box_hull(const glm::vec3& half) {
    std::vector<glm::dvec3> corners;
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0})
            for (const double z : {-1.0, 1.0}) corners.push_back(glm::dvec3(half) * glm::dvec3(x, y, z));
    return collision_hull(corners, glm::dvec3(0.0));
}

inline glm::mat3 box_inertia(const glm::vec3& half, float mass) {
    const glm::vec3 square = half * half * (mass / 3.0f);
    glm::mat3 inertia(0.0f);
    inertia[0][0] = square.y + square.z;
    inertia[1][1] = square.x + square.z;
    inertia[2][2] = square.x + square.y;
    return inertia;
}

inline BodyDesc box(const glm::vec3& half, float mass, const glm::vec3& position) {
    BodyDesc desc;
    desc.hull = box_hull(half);
    desc.mass = mass;
    desc.inertia = box_inertia(half, mass);
    desc.pose.position = position;
    return desc;
}

// The box as a compound of `count` slabs along x.
inline BodyDesc in_slabs(BodyDesc box, const glm::vec3& half, int count) {
    box.hull = {};
    const float width = half.x / static_cast<float>(count);
    const auto hull = std::make_shared<const CollisionHull>(box_hull({width, half.y, half.z}));
    for (int i = 0; i < count; ++i)
        box.parts.push_back({hull, {-half.x + width * static_cast<float>(2 * i + 1), 0.0f, 0.0f}});
    return box;
}

// A cube of one kilogram and 10 cm, far above the size of small debris.
inline constexpr float block_half = 0.05f;
inline BodyDesc block(const glm::vec3& at, bool debris = false) {
    BodyDesc desc = box(glm::vec3(block_half), 1.0f, at);
    desc.debris = debris;
    return desc;
}

inline BodyId must_add(World& world, const BodyDesc& desc) {
    const Result<BodyId> id = world.add_body(desc);
    REQUIRE_MESSAGE(id.has_value(), (id ? std::string() : id.error().message));
    return *id;
}

// By body order.
inline std::vector<Pose> poses_of(const World& world, float alpha = 1.0f) {
    std::vector<Pose> poses(world.body_count());
    world.visit_poses(alpha, 0, [&](size_t i, const Pose& pose) { poses[i] = pose; });
    return poses;
}

inline void run(World& world, float seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds / world.settings().step)); ++i) world.step();
}

// Checks that `play`, which fills an empty world, runs it and returns the hash of its state, returns equal hashes in a
// new world and in a cleared one.
inline void check_repeats(const auto& play) {
    World first, second;
    const uint64_t hash = play(first);
    CHECK(play(second) == hash);
    first.clear();
    CHECK(first.state_hash() != hash);
    CHECK(play(first) == hash);
}

inline float greatest_speed(const World& world) {
    float most = 0.0f;
    for (const BodyId id : world.bodies()) most = std::max(most, glm::length(world.linear_velocity(id)));
    return most;
}

inline double energy_of(const World& world) {
    const Mechanics now = world.mechanics();
    return now.kinetic + now.potential;
}

// Rises of the energy of a closed system, step by step. They are summed, since hundreds of small rises may add up.
struct EnergyBooks {
    explicit EnergyBooks(const World& world) : start(energy_of(world)), last(start), least(start) {}
    void look(const World& world) {
        const double now = energy_of(world);
        steepest = std::max(steepest, now - last);
        risen += std::max(now - last, 0.0);
        max_above_min = std::max(max_above_min, now - least);
        least = std::min(least, now);
        last = now;
    }

    double start, last, least;  // J
    double steepest = 0.0;      // J, largest rise in a step
    double risen = 0.0;         // J, sum of all rises
    double max_above_min = 0.0; // J, largest excess over the least before
};

// The largest motion of bodies that rest in empty space. A body moves only if it overlaps another; the correction of
// overlaps moves it without giving it velocity.
struct Drift {
    float speed = 0.0f; // m/s, maximum over bodies and steps
    float way = 0.0f;   // m, largest distance of a body from its place
};
inline Drift drift(World& world, int steps, const std::function<void()>& after_step = {}) {
    std::vector<glm::vec3> places;
    for (const BodyId id : world.bodies()) places.push_back(world.pose(id).position);
    Drift most;
    for (int step = 0; step < steps; ++step) {
        world.step();
        if (after_step) after_step();
        REQUIRE(world.body_count() == places.size());
        most.speed = std::max(most.speed, greatest_speed(world));
        for (size_t i = 0; i < places.size(); ++i)
            most.way = std::max(most.way, glm::length(world.pose(world.bodies()[i]).position - places[i]));
    }
    return most;
}

// Scaled about the mean of its points.
inline std::shared_ptr<const CollisionHull> inflated(const CollisionHull& hull, float factor) {
    auto larger = std::make_shared<CollisionHull>(hull);
    glm::vec3 middle(0.0f);
    for (const glm::vec3& p : larger->points) middle += p / static_cast<float>(larger->points.size());
    for (glm::vec3& p : larger->points) p = middle + (p - middle) * factor;
    larger->section = {};
    return larger;
}

inline bool all_finite(const World& world) {
    return std::ranges::all_of(world.bodies(), [&](BodyId id) {
        const Pose pose = world.pose(id);
        const glm::vec3 v = world.linear_velocity(id), w = world.angular_velocity(id);
        return std::isfinite(glm::dot(pose.position, pose.position) + glm::dot(v, v) + glm::dot(w, w))
               && std::isfinite(glm::dot(pose.orientation, pose.orientation));
    });
}

} // namespace brittle::physics::test_bodies
