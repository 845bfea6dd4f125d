// Dust and splinters that breaks throw off. They are drawn and have no effect on bodies.
//
//     Particles particles;
//     particles.burst({.at = at, .normal = normal, .area = 0.02f}, {.colour = grey}, seed);
//     each step of the world: particles.step(seconds);
//     each frame: particles.draw(alpha, splinters, dust);
//
// Equal bursts and steps give equal particles. World coordinates, metres, seconds.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "engine/render/scene.h"

namespace brittle::tools {

// A part of a surface along which something broke.
struct Crack {
    glm::vec3 at{0.0f};
    glm::vec3 normal{0.0f, 1.0f, 0.0f}; // unit, of the surface; its sign is of no importance
    glm::vec3 velocity{0.0f};           // m/s, of what broke
    float area = 0.0f;                  // m^2
};

// What a material throws off. The amounts are factors, 1 for stone.
struct ParticleLook {
    glm::vec3 splinter_colour{0.5f}, dust_colour{0.6f}; // linear
    float splinters = 1.0f, dust = 1.0f;
    float length = 1.0f; // factor of the length of splinters
    float width = 0.5f;  // Splinter::width, the greatest
};

class Particles {
  public:
    static constexpr size_t max_splinters = 3000, max_puffs = 200;

    // The ground stops particles. Nothing: there is none.
    void set_ground(bool exists, float height);
    // Throws off particles of a crack: more of a larger one, and fewer as their number nears its limit.
    void burst(const Crack& crack, const ParticleLook& look, uint64_t seed);
    void step(float seconds);
    void clear();

    // Appends the particles as they are `alpha` steps, 0 to 1, after the step before the last.
    void draw(float alpha, std::vector<engine::Splinter>& splinters, std::vector<engine::DustPuff>& dust) const;
    // Whether steps change nothing: no particle is left.
    [[nodiscard]] bool empty() const { return splinters_.empty() && puffs_.empty(); }
    [[nodiscard]] size_t splinter_count() const { return splinters_.size(); }
    [[nodiscard]] size_t puff_count() const { return puffs_.size(); }

  private:
    struct Flying {
        glm::vec3 at, velocity;
        float age = 0.0f, life = 1.0f; // s
    };
    struct FlyingSplinter : Flying {
        glm::quat rotation;
        glm::vec3 spin; // rad/s, world axes
        float length, width;
        glm::vec3 colour;
        bool rests = false;
    };
    struct FlyingPuff : Flying {
        float radius; // m, at birth
        float opacity;
        glm::vec3 colour;
        uint32_t pattern;
    };
    void move(FlyingSplinter& splinter, float seconds) const;
    void move(FlyingPuff& puff, float seconds) const;

    std::vector<FlyingSplinter> splinters_;
    std::vector<FlyingPuff> puffs_;
    bool has_ground_ = true;
    float ground_ = 0.0f;  // m
    float seconds_ = 0.0f; // of the last step
};

} // namespace brittle::tools
