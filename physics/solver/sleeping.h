// Which bodies come to rest, and which are ready to sleep.
//
// - Ready to sleep: a body that touches something and has been slow for WorldSettings::sleep_seconds. For the second
//   half of that time its velocity is damped. One tremble does not start the wait anew; a body that only rocks in
//   place waits longer, however fast; one that is too deep in the ground waits until it has come up. An island sleeps
//   as soon as all of its bodies are ready (islands.h).
// - Quiet: in a large heap some light piece between heavy ones always trembles, because the solver knows what presses
//   on it to a few per cent only. Where nine tenths of an island's mass are still and nothing is faster than a
//   tremble, its other bodies count as still after twice the time.
// - Resting: a body that is ready inside an island that is still awake gets infinite mass, until something disturbs
//   it: a body that it touches moves and is not ready, or is gone. Otherwise a large heap never sleeps: the solver
//   leaves every body some creep, and every few seconds a piece that has crept far enough falls and keeps all others
//   awake and creeping. No body of an island rests while one of it is fast, because all take a blow, or waits to come
//   up from the ground, because all must yield.
//
// Not thread-safe, but works on several threads itself.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "physics/solver/body.h"
#include "physics/solver/islands.h"
#include "physics/world/world.h"

namespace brittle::physics {

class Sleeping {
  public:
    Sleeping(const WorldSettings& settings, const std::vector<std::unique_ptr<Body>>& bodies, const Islands& islands,
             fracture::Threads& threads)
        : settings_(settings), bodies_(bodies), islands_(islands), threads_(threads) {}

    // Before the contacts are solved: sets Body::resting, and clears the velocities of resting bodies.
    void let_rest(float seconds);
    // After the bodies have moved: sets their activity.
    void settle(float seconds);

  private:
    // What a body touches, as far as it decides on its rest.
    struct Company {
        uint32_t contact_groups = 0; // of four points, rounded up for each manifold
        bool pressed = false;        // in the last step
        bool disturbed = false;      // by a moving body that it touches
        bool busy = false;           // by island: no body of it rests
    };
    struct Touching {
        bool any = false, sunk = false; // Body::touching and sunk
    };
    struct Calm {
        float mass = 0.0f, still_mass = 0.0f; // kg
        bool fast = false;                    // one of its bodies
    };

    void find_company();
    void let_rest(Body& body, float seconds) const;
    void find_touching(float seconds);
    void count_still(Body& body, float seconds) const;
    [[nodiscard]] bool rocks_in_place(Body& body, float seconds) const;
    void find_calm();
    void count_quiet(Body& body, float seconds) const;

    [[nodiscard]] float speed_of(const Body& body) const; // in sleeping speeds
    [[nodiscard]] bool is_fast(const Body& body) const;   // too fast for a tremble
    [[nodiscard]] float waited(const Body& body) const;   // s
    [[nodiscard]] bool rises(const Body& body) const;     // out of the ground

    const WorldSettings& settings_;
    const std::vector<std::unique_ptr<Body>>& bodies_;
    const Islands& islands_;
    fracture::Threads& threads_;
    // Scratch of one step, by body; company's `busy` and calm by island.
    std::vector<Company> company_;
    std::vector<Touching> touching_;
    std::vector<Calm> calm_;
};

} // namespace brittle::physics
