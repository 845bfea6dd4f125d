#include "physics/solver/free_rotation.h"

#include <algorithm>
#include <cmath>

namespace brittle::physics {

Spin free_spin(const Spin& spin, const glm::dvec3& moments, double seconds) {
    const double fastest = max_turn_per_substep * max_spin_substeps / seconds;
    glm::dvec3 velocity = spin.velocity;
    const double speed = glm::length(velocity);
    if (!(speed > 0.0)) return spin;
    if (speed > fastest) velocity *= fastest / speed;

    const auto substeps = static_cast<int>(
        std::clamp(std::ceil(speed * seconds / max_turn_per_substep), 1.0, static_cast<double>(max_spin_substeps)));
    const double h = seconds / substeps, settled = 1e-12 * speed;
    glm::dquat orientation = spin.orientation;
    glm::dvec3 body = glm::conjugate(orientation) * velocity;
    for (int substep = 0; substep < substeps; ++substep) {
        // Euler's equation at the midpoint: I (m - w) = h/2 (I m) x m, where m = (w + w') / 2.
        glm::dvec3 middle = body;
        for (int iteration = 0; iteration < 40; ++iteration) {
            const glm::dvec3 next = body + 0.5 * h * glm::cross(moments * middle, middle) / moments;
            const glm::dvec3 change = next - middle;
            middle = next;
            if (glm::dot(change, change) <= settled * settled) break;
        }
        body = 2.0 * middle - body;
        // The Cayley map of h m is the normalised quaternion (1, h m / 2). Its inverse is the rotation of the angular
        // momentum in body axes above, so the angular momentum in world axes is constant.
        orientation = glm::normalize(orientation * glm::dquat(1.0, 0.5 * h * middle));
    }
    return {orientation, orientation * body};
}

} // namespace brittle::physics
