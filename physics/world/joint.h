// Joints: a ball joint, a hinge, a distance joint (rod, rope, strut) or a fixed joint (weld) between two bodies, or a
// body and the world.
//
//     Result<JointId> rope = world.add_joint({.kind = JointKind::distance, .a = ball, .anchor_a = eye, .anchor_b = hook,
//                                             .max_length = 3.0f, .max_force = 2e4f});
//     each step:
//         world.step();
//         for (const JointId broken : world.broken_joints()) ...
//
// - Ball: the two anchors stay at one point. Hinge: moreover the two axes stay parallel. Distance: the distance of the
//   anchors stays between min_length and max_length; a rope has no min_length, a rod has two equal ones. Fixed: the two
//   bodies keep their place and turn to each other.
// - Two jointed bodies sleep and wake together. A body that hangs from a joint may sleep.
// - Removing a body removes its joints. World::take_joints() hands them on to the pieces of a body that breaks.
// - A joint breaks in the step in which it would need more than max_force. In that step it still gives max_force.
//   The force is the impulse of the step divided by its time: a jerk that stops a ton at 1 m/s in a step of 1/120 s
//   needs 120 kN. The torque of a hinge breaks nothing. A fixed joint breaks where the shares of force and torque that
//   it needs exceed 1 together: force / max_force + torque / max_torque, the torque about the anchor.
// - Where two joints hold a body twice (the hinges of a door), the one that was added first bears the load that either
//   could bear. Fixed joints share such a load by their max_force.
//
// World coordinates, metres, newtons, unless stated.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <limits>

#include <glm/vec3.hpp>

#include "physics/world/world.h"

namespace brittle::physics {

inline constexpr std::array joint_kinds{JointKind::ball, JointKind::hinge, JointKind::distance, JointKind::fixed};
// As in recipes: ball, hinge, distance, fixed.
[[nodiscard]] constexpr const char* to_string(JointKind kind) {
    return std::array{"ball", "hinge", "distance", "fixed"}[static_cast<size_t>(kind)];
}

// A joint as it is added, in world coordinates of that time.
struct JointDesc {
    JointKind kind = JointKind::ball;
    BodyId a;
    BodyId b{};               // the default: the world
    glm::vec3 anchor_a{0.0f}; // on a; of all but a distance joint the common point
    glm::vec3 anchor_b{0.0f}; // on b, of a distance joint; not read for the others
    // Of a hinge; of a fixed joint that bears pressure the direction from a to b. Any length but zero.
    glm::vec3 axis{0.0f, 1.0f, 0.0f};
    float min_length = 0.0f;                                   // m, of a distance joint
    float max_length = std::numeric_limits<float>::infinity(); // m, of a distance joint; > 0
    float max_force = std::numeric_limits<float>::infinity();  // N, > 0; infinity: it never breaks
    float max_torque = std::numeric_limits<float>::infinity(); // N m, > 0, of a fixed joint
    // Of a fixed joint, such as glue between two faces: what presses a and b together along the axis does not count.
    bool bears_pressure = false;
    bool collide = false; // whether the two bodies collide with each other
};

// A side of a joint: in the axes of its body and relative to its centre of mass; in world coordinates for the world.
struct JointSide {
    BodyId body{}; // the default: the world
    glm::vec3 anchor{0.0f};
    glm::vec3 axis{0.0f}; // unit; of a hinge and a fixed joint
    glm::vec3 up{0.0f};   // unit, across the axis; of a fixed joint
};

// A joint of a World.
struct Joint {
    JointKind kind = JointKind::ball;
    JointSide a, b;
    float min_length = 0.0f, max_length = 0.0f, max_force = 0.0f, max_torque = 0.0f; // as in JointDesc
    bool bears_pressure = false, collide = false;
};

// A joint that lost a side: see World::take_joints().
struct LooseJoint {
    JointId id;
    Joint joint;
    bool second = false;    // whether b is lost, else a
    glm::vec3 anchor{0.0f}; // of the lost side, in world coordinates
    glm::vec3 axis{0.0f}, up{0.0f};
};

} // namespace brittle::physics
