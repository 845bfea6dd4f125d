// Velocities, responses and impulses at points of bodies, for code that breaks them.
//
// World coordinates, SI units. A body that is not in the world has zero velocity and infinite mass.
#pragma once

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "physics/world/world.h"

namespace brittle::physics {

// Rotates a vector from body axes to world axes.
[[nodiscard]] inline glm::dvec3 to_world_axes(const Pose& pose, const glm::dvec3& arm) {
    return glm::dquat(pose.orientation) * arm;
}

// Rotates a vector from world axes to body axes.
[[nodiscard]] inline glm::dvec3 to_body_axes(const Pose& pose, const glm::vec3& arm) {
    return glm::conjugate(glm::dquat(pose.orientation)) * glm::dvec3(arm);
}

// Returns the pose of a frame at an offset (m, body axes) from the body's, with the body's orientation.
[[nodiscard]] inline Pose offset_pose(const Pose& body, const glm::dvec3& arm) {
    return {glm::vec3(glm::dvec3(body.position) + to_world_axes(body, arm)), body.orientation};
}

// Returns the velocity, m/s, of a body's point along a unit direction.
[[nodiscard]] inline float velocity_along(const World& world, BodyId body, const glm::vec3& point,
                                          const glm::vec3& direction) {
    if (!world.contains(body)) return 0.0f;
    const glm::vec3 arm = point - world.pose(body).position;
    return glm::dot(world.linear_velocity(body) + glm::cross(world.angular_velocity(body), arm), direction);
}

// Returns World::response(), in 1/kg.
[[nodiscard]] inline float response_at(const World& world, BodyId body, const glm::vec3& point,
                                       const glm::vec3& direction) {
    return world.contains(body) ? world.response(body, point, direction) : 0.0f;
}

inline void apply_impulse(World& world, BodyId body, const glm::vec3& impulse, const glm::vec3& point) {
    if (world.contains(body)) world.apply_impulse(body, impulse, point);
}

} // namespace brittle::physics
