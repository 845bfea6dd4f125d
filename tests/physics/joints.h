// Joints and their measurements for tests of the world.
#pragma once

#include <optional>
#include <string>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "physics/world/joint.h"
#include "physics/world/world.h"

namespace brittle::physics::test_bodies {

inline constexpr float g = 9.81f; // m/s^2

inline const WorldSettings in_vacuum{.ground_height = std::nullopt, .air_density = 0.0f, .sleeping = false};

inline JointId must_join(World& world, const JointDesc& desc) {
    const Result<JointId> id = world.add_joint(desc);
    REQUIRE_MESSAGE(id.has_value(), (id ? std::string() : id.error().message));
    return *id;
}

// m, between the two anchors.
inline float opening(const World& world, JointId joint) {
    return glm::length(world.joint_anchor(joint, true) - world.joint_anchor(joint, false));
}

} // namespace brittle::physics::test_bodies
