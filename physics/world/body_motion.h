// Small sums over the motion of bodies that breaking things needs in several places.
//
// World coordinates, SI units. Bodies that are not in the world neither move nor give way.
#pragma once

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "physics/world/world.h"

namespace brittle::physics {

[[nodiscard]] inline glm::dvec3 turned(const Pose& pose, const glm::dvec3& arm) {
    return glm::dquat(pose.orientation) * arm;
}

[[nodiscard]] inline glm::dvec3 turned_back(const Pose& pose, const glm::vec3& arm) {
    return glm::conjugate(glm::dquat(pose.orientation)) * glm::dvec3(arm);
}

// The pose of what is at an arm, in body axes, from a body.
[[nodiscard]] inline Pose moved(const Pose& body, const glm::dvec3& arm) {
    return {glm::vec3(glm::dvec3(body.position) + turned(body, arm)), body.orientation};
}

// Of a body's point, along a unit direction.
[[nodiscard]] inline float speed_at(const World& world, BodyId body, const glm::vec3& point,
                                    const glm::vec3& direction) {
    if (!world.contains(body)) return 0.0f;
    const glm::vec3 arm = point - world.pose(body).position;
    return glm::dot(world.linear_velocity(body) + glm::cross(world.angular_velocity(body), arm), direction);
}

[[nodiscard]] inline float response_at(const World& world, BodyId body, const glm::vec3& point,
                                       const glm::vec3& direction) {
    return world.contains(body) ? world.response(body, point, direction) : 0.0f;
}

inline void push(World& world, BodyId body, const glm::vec3& impulse, const glm::vec3& point) {
    if (world.contains(body)) world.apply_impulse(body, impulse, point);
}

} // namespace brittle::physics
