#include "physics/cutting/suspended_contact.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "physics/world/body_motion.h"

namespace brittle::physics {

namespace {

// The contact lies at its old arm from the striker. A fast striker has moved far since the contact, and a ball whose
// contact point has slid would be left spinning by an impulse at the old place.
glm::vec3 point_of(const World& world, const SuspendedContact& contact) {
    return world.pose(contact.striker).position + contact.arm;
}

// J that the two lost by an impulse on the piece, and by its reaction on the striker, just before.
double energy_lost(const World& world, BodyId piece, const SuspendedContact& contact, const glm::vec3& impulse) {
    const float size = glm::length(impulse);
    if (!(size > 0.0f)) return 0.0;
    const glm::vec3 direction = impulse / size, point = point_of(world, contact);
    const float approach =
        velocity_along(world, contact.striker, point, direction) - velocity_along(world, piece, point, direction);
    const float response =
        response_at(world, contact.striker, point, direction) + response_at(world, piece, point, direction);
    return static_cast<double>(size * (approach + 0.5f * size * response));
}

} // namespace

bool SuspendedContact::empty() const {
    return !(glm::length(normal_impulse) > 0.0f);
}

// Half a bounce off a pane that then has a hole would be visible, and so would a body that sinks into the piece.
void suspend(World& world, BodyId piece, SuspendedContact& contact) {
    const float max_impulse = glm::length(contact.normal_impulse);
    if (!(max_impulse > 0.0f)) return;
    const glm::vec3 normal = contact.normal_impulse / max_impulse;
    const glm::vec3 point = point_of(world, contact);
    const float separation =
        velocity_along(world, piece, point, normal) - velocity_along(world, contact.striker, point, normal);
    const float response =
        response_at(world, piece, point, normal) + response_at(world, contact.striker, point, normal);
    if (!(response > 0.0f)) return;
    const float bounce = std::clamp(separation / response, 0.0f, max_impulse);
    apply_impulse(world, piece, -bounce * normal, point);
    apply_impulse(world, contact.striker, bounce * normal, point);
    contact.normal_impulse = (max_impulse - bounce) * normal;
}

// A free piece may have passed the impulse on. Its loss by this impulse is then more than the contact dissipated.
void add_friction(const World& world, BodyId piece, const glm::vec3& friction, SuspendedContact& contact) {
    contact.friction_impulse = friction;
    const double lost = energy_lost(world, piece, contact, contact.normal_impulse + friction);
    contact.lost = world.fixed(piece) ? std::max(contact.lost, lost) : std::clamp(lost, 0.0, contact.lost);
}

void restore(World& world, BodyId piece, double crack_share, SuspendedContact& contact) {
    if (!world.contains(contact.striker) || !world.contains(piece)) contact.normal_impulse = glm::vec3(0.0f);
    if (contact.empty()) return;
    const auto scale = [&](double share) {
        contact.normal_impulse *= static_cast<float>(share);
        contact.friction_impulse *= static_cast<float>(share);
    };
    scale(std::sqrt(std::max(0.0, 1.0 - crack_share)));
    const float size = glm::length(contact.normal_impulse + contact.friction_impulse);
    if (!(size > 0.0f)) return;
    const glm::vec3 direction = (contact.normal_impulse + contact.friction_impulse) / size;
    const glm::vec3 point = point_of(world, contact);
    // A share s of the impulse brings the energy  linear s + quadratic s^2.
    const double linear = static_cast<double>(
        size
        * (velocity_along(world, contact.striker, point, direction) - velocity_along(world, piece, point, direction)));
    const double response = static_cast<double>(response_at(world, contact.striker, point, direction)
                                                + response_at(world, piece, point, direction));
    const double quadratic = 0.5 * response * static_cast<double>(size) * static_cast<double>(size);
    if (linear + quadratic > contact.lost && quadratic > 0.0) {
        const double root = std::sqrt(linear * linear + 4.0 * quadratic * contact.lost);
        scale(std::clamp((root - linear) / (2.0 * quadratic), 0.0, 1.0));
    }
    apply_impulse(world, piece, -contact.normal_impulse - contact.friction_impulse, point);
    apply_impulse(world, contact.striker, contact.normal_impulse + contact.friction_impulse, point);
}

void solve_again(World& world, BodyId part, SuspendedContact& contact) {
    const float max_normal = glm::length(contact.normal_impulse);
    if (!(max_normal > 0.0f)) return;
    const glm::vec3 point = point_of(world, contact);
    double lost = 0.0;
    const auto stop = [&](const glm::vec3& direction, float max_impulse) {
        const float approach =
            velocity_along(world, contact.striker, point, direction) - velocity_along(world, part, point, direction);
        const float response =
            response_at(world, part, point, direction) + response_at(world, contact.striker, point, direction);
        const float impulse = response > 0.0f ? std::clamp(approach / response, 0.0f, max_impulse) : 0.0f;
        apply_impulse(world, part, impulse * direction, point);
        apply_impulse(world, contact.striker, -impulse * direction, point);
        lost += static_cast<double>(impulse * (approach - 0.5f * response * impulse));
        return impulse;
    };
    const glm::vec3 normal = contact.normal_impulse / max_normal;
    const float impulse = stop(normal, max_normal), max_friction = glm::length(contact.friction_impulse);
    contact.normal_impulse = impulse * normal;
    if (max_friction > 0.0f) {
        const glm::vec3 along = contact.friction_impulse / max_friction;
        contact.friction_impulse = stop(along, max_friction * (impulse / max_normal)) * along;
    }
    contact.lost = std::min(contact.lost, lost);
}

} // namespace brittle::physics
