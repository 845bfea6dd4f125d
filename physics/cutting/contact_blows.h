// Contacts that were blows: what one body did to another, as one, however many steps it took.
//
// What comes slowly, lands flat or has a gap left to close gives its impulse in several steps: a step's solution stops it only
// as far as the gap allows. A blow is over when the two no longer approach each other faster than the least speed, or no
// longer press, at the latest after four steps. Contacts that are slower never count, so what rests never adds up to a blow.
//
//     BlowBook book;
//     each step: world.step();
//                for (const BodyBlow& blow : book.take_up(world, 0.5f, wanted)) ...   // those that ended with it
//
// N s, J, m. Those of before come first, then in the order of the contacts. Every call gets the same world.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "physics/world/world.h"

namespace brittle::physics {

struct BodyBlow {
    BodyId body;
    BodyId other;             // the default for the ground
    glm::vec3 point{0.0f};    // from the body's centre of mass, in its axes; weighed by impulse, as is
    glm::vec3 arm{0.0f};      // that from the other's centre of mass when it was, world axes
    glm::vec3 normal{0.0f};   // unit, world, towards the body
    float impulse = 0.0f;     // along the normal
    glm::vec3 friction{0.0f}; // what the body got across it
    float energy = 0.0f;      // half of impulse times first approach speed: what a dead blow turns into cracks and heat
    // The impulse as if something of a kilogram gave it: blows of more mass take longer (impact_seconds in material.h), as
    // the cube root of the mass that is stopped, impulse / speed.
    float sharp = 0.0f;
};

class BlowBook {
  public:
    static constexpr int max_steps = 4; // of one blow; a longer push is several

    // To be called after each step of the world: the blows that are over. Of contacts that came in faster than speed (m/s); a
    // body that `wanted` refuses is hit by none.
    [[nodiscard]] std::vector<BodyBlow> take_up(const World& world, float speed,
                                                const std::function<bool(BodyId)>& wanted);

  private:
    struct Running {
        BodyBlow blow;        // its normal is the sum of impulses
        float pressed = 0.0f; // N s, the sum whatever their directions
        float speed = 0.0f;   // m/s, mean of its first step
        int steps = 1;
    };
    static std::vector<Running> of_step(const World& world, float speed, const std::function<bool(BodyId)>& wanted);
    static void join(Running& now, const Running& before);
    static bool goes_on(const World& world, const Running& running, float speed);
    static BodyBlow ended(const Running& running);

    std::vector<Running> running_;
};

} // namespace brittle::physics
