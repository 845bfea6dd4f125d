// Dust and splinters that breaks throw off. They are drawn and have no effect on bodies.
//
//     Particles particles;
//     particles.burst({.at = at, .normal = normal, .area = 0.02f}, {.colour = grey}, seed);
//     each step of the world: particles.step(seconds, obstacles);
//     each frame: particles.draw(alpha, splinters, dust);
//
// The ground and obstacles stop particles. A particle asks for obstacles every look_steps steps, for its way until it
// asks again; one that rests asks every support_steps steps whether its support is still there. So a step asks for about
// a quarter of the particles. A new particle meets no obstacle at first, since it begins between the faces of a crack.
// An obstacle that moves over a particle between two questions swallows it.
//
// Equal bursts, steps and obstacles give equal particles. World coordinates, metres, seconds.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
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

// The way of a particle in its next steps, taken as straight.
struct Way {
    glm::vec3 from, to;
};

// Where a way enters a solid.
struct Obstacle {
    glm::vec3 point, normal;  // of the surface; unit, outward
    glm::vec3 velocity{0.0f}; // m/s, of that point
};

// Finds for each way the first solid that it enters from outside; the second span is as long, and empty at the call.
// Ways that follow each other are often near each other.
using Obstacles = std::function<void(std::span<const Way> ways, std::span<std::optional<Obstacle>> met)>;

class Particles {
  public:
    static constexpr size_t max_splinters = 3000, max_puffs = 200;
    static constexpr uint32_t look_steps = 4, support_steps = 12; // between questions: in flight, at rest

    // The ground stops particles. Nothing: there is none.
    void set_ground(bool exists, float height);
    // Throws off particles of a crack: more of a larger one, and fewer as their number nears its limit.
    void burst(const Crack& crack, const ParticleLook& look, uint64_t seed);
    // `obstacles`: empty for none.
    void step(float seconds, const Obstacles& obstacles = {});
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
        float age = 0.0f, life = 1.0f;   // s
        uint32_t look_in = 0;            // steps until it asks for obstacles
        bool rests = false;              // on `ahead` if there is one, else on the ground
        std::optional<Obstacle> ahead{}; // that it meets before it asks again, or rests on
        float gap = 0.0f;                // m, that it keeps from the surface of `ahead`
    };
    struct FlyingSplinter : Flying {
        glm::quat rotation;
        glm::vec3 spin; // rad/s, world axes
        float length, width;
        glm::vec3 colour;
    };
    struct FlyingPuff : Flying {
        float radius; // m, at birth
        float opacity;
        glm::vec3 colour;
        uint32_t pattern;
    };
    [[nodiscard]] static Way way_of(const FlyingSplinter& splinter, float seconds);
    [[nodiscard]] static Way way_of(const FlyingPuff& puff, float seconds);
    static void take(FlyingSplinter& splinter, const std::optional<Obstacle>& met);
    static void take(FlyingPuff& puff, const std::optional<Obstacle>& met);
    // Asks for the obstacles of the particles whose turn it is.
    void look(auto& all, float seconds, const Obstacles& obstacles);
    static void bounce(FlyingSplinter& splinter, const Obstacle& obstacle, float gap);
    void move(FlyingSplinter& splinter, float seconds) const;
    void move(FlyingPuff& puff, float seconds) const;

    std::vector<FlyingSplinter> splinters_;
    std::vector<FlyingPuff> puffs_;
    bool has_ground_ = true;
    float ground_ = 0.0f;   // m
    float seconds_ = 0.0f;  // of the last step
    uint32_t bursts_ = 0;   // particles of a burst look ahead in the same steps, those of the next burst a step later
    std::vector<Way> ways_; // scratch of look(), with the next two lines
    std::vector<size_t> looking_;
    std::vector<std::optional<Obstacle>> met_;
};

} // namespace brittle::tools
