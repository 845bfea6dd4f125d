// Decides which bodies are ready to sleep and which rest.
//
// - Ready to sleep: a body that touches something and has been slow (below both sleeping speeds) for
//   WorldSettings::sleep_seconds. During the second half of that time its velocity is damped. A short tremble reduces
//   the time instead of resetting it; a body that rocks in place waits longer, at any speed; a body that is too deep in
//   the ground waits until it has risen; a body that slides, all of its friction at the bound, does not count as slow.
//   An island sleeps once all of its bodies are ready (islands.h).
// - Calm island: in a large heap some light piece between heavy ones always trembles, because the solver's forces on it
//   are exact to a few per cent only. If nine tenths of an island's mass are still and nothing is faster than a
//   tremble, the other bodies count as still after twice the time.
// - A body with a joint counts as one that touches something, and never rests in an awake island.
// - Resting: a ready body inside an island that is still awake gets infinite mass until something disturbs it: a body
//   that it touches moves and is not ready, or is gone. Without resting bodies a large heap never sleeps: the solver
//   leaves every body some creep, and every few seconds a piece that has crept far enough falls and keeps all others
//   awake and creeping. No body of an island rests while a body of the island is fast, because all must take its blow,
//   or rises out of the ground, because all must yield to it.
//
// Not thread-safe; works on several threads itself.
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

    // Sets Body::resting and clears the velocities of resting bodies. Call it before the contacts are solved.
    void update_resting(float seconds);
    // Sets the activity of bodies. Call it after they have moved.
    void settle(float seconds);

  private:
    // Facts about the contacts of a body that decide whether it rests.
    struct ContactState {
        uint32_t contact_groups = 0; // groups of up to four points, by manifold
        bool is_loaded = false;      // a contact had an impulse in the last step
        bool disturbed = false;      // by a moving body that it touches
        bool busy = false;           // by island: none of its bodies may rest
    };
    struct Touching {
        bool any = false, sunk = false;     // Body::touching and Body::sunk
        bool loaded = false, holds = false; // a contact with an impulse; one whose friction is below its bound
    };
    struct Calm {
        float mass = 0.0f, still_mass = 0.0f; // kg
        bool fast = false;                    // at least one of its bodies is
    };

    void find_contact_states();
    void update_resting(Body& body, float seconds) const;
    void find_touching(float seconds);
    void count_still(Body& body, float seconds) const;
    [[nodiscard]] bool rocks_in_place(Body& body, float seconds) const;
    void find_calm();
    void count_quiet(Body& body, float seconds) const;

    [[nodiscard]] float speed_of(const Body& body) const; // as a multiple of the sleeping speeds
    [[nodiscard]] bool is_fast(const Body& body) const;   // faster than a tremble
    [[nodiscard]] float waited(const Body& body) const;   // s, of being still
    [[nodiscard]] bool rises(const Body& body) const;     // out of the ground

    const WorldSettings& settings_;
    const std::vector<std::unique_ptr<Body>>& bodies_;
    const Islands& islands_;
    fracture::Threads& threads_;
    // Scratch of one step, by body; ContactState::busy and calm_ by island.
    std::vector<ContactState> contact_states_;
    std::vector<Touching> touching_;
    std::vector<Calm> calm_;
};

} // namespace brittle::physics
