#pragma once

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace brittle::physics {

// The velocity of a rigid body, in world axes.
struct Velocity {
    glm::vec3 linear{0.0f};  // m/s, of the centre of mass
    glm::vec3 angular{0.0f}; // rad/s

    // m/s, of the body's point at a lever arm from its centre of mass.
    [[nodiscard]] glm::vec3 at(const glm::vec3& arm) const { return linear + glm::cross(angular, arm); }
};

} // namespace brittle::physics
