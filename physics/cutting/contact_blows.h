// Blows: the contacts of one body with another, summed over the steps that the collision lasts.
//
// The step in which two bodies meet stops them whole, at any time within it. A collision lasts for several steps where
// something pushes on, as a heavy body behind a light one. A blow ends when the bodies no longer approach each other
// faster than the speed limit, when they no longer touch, or after max_steps. Slower contacts never count, so a resting
// body never adds up to a blow.
//
//     BlowTracker tracker;
//     each step: world.step();
//                for (const BodyBlow& blow : tracker.update(world, 0.5f, filter)) ...   // ended in this step
//
// N s, J, m. Order: blows of earlier steps first, then by contact. Every call gets the same world. Not thread-safe.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "physics/world/world.h"

namespace brittle::physics {

struct BodyBlow {
    BodyId body;
    BodyId other;           // the default for the ground
    glm::vec3 point{0.0f};  // m, from the body's centre of mass in body axes; mean of the contacts weighted by impulse
    glm::vec3 arm{0.0f};    // m, from the other's centre of mass in world axes, at the time of contact; weighted alike
    glm::vec3 normal{0.0f}; // unit, world axes, towards the body
    float impulse = 0.0f;   // N s, along the normal
    glm::vec3 friction{0.0f}; // N s, on the body, world axes
    float energy = 0.0f; // J, half of impulse times first approach speed: the loss of a perfectly inelastic collision
    // Impulse, N s, of a blow by one kilogram that stresses the body equally. The duration of a blow grows with the
    // cube root of the mass that is stopped, impulse / speed (impact_seconds in material.h), and the stress falls with
    // the duration.
    float equivalent_impulse = 0.0f;
};

// Energy of the bounce, J: half of the impulse times the speed at which the two separate after the step in which the
// blow ended. The contact dissipated the rest of BodyBlow::energy. At least 0.
[[nodiscard]] float bounce_energy(const World& world, const BodyBlow& blow);

class BlowTracker {
  public:
    static constexpr int max_steps = 4; // of one blow; a longer push is several blows

    // Call after each step of the world. Returns the blows that ended, on bodies that `filter` accepts, of contacts
    // that came in faster than `speed`, m/s.
    [[nodiscard]] std::vector<BodyBlow> update(const World& world, float speed,
                                               const std::function<bool(BodyId)>& filter);

  private:
    struct Running {
        BodyBlow blow;              // its normal is the sum of the impulses
        float total_impulse = 0.0f; // N s, sum of the magnitudes
        float speed = 0.0f;         // m/s, mean approach speed of its first step
        int steps = 1;
    };
    static std::vector<Running> blows_of_step(const World& world, float speed,
                                              const std::function<bool(BodyId)>& filter);
    static void join(Running& now, const Running& before);
    static bool continues(const World& world, const Running& running, float speed);
    static BodyBlow ended(const Running& running);

    std::vector<Running> running_;
};

} // namespace brittle::physics
