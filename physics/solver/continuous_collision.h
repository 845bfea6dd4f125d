// Continuous collision: a fast body stops at its time of impact (time_of_impact.h).
//
// The path of a body that moves by more than a quarter of its own thickness in a step is searched for other bodies. At
// an impact the body stops for the rest of the step and keeps its velocity; the next step solves the contact with the
// full speed, so that a blow is one impulse and a bounce has its full height. The search changes no bit of bodies that
// pass without touching, slide or part.
//
// - No body passes through a fixed one. Pairs of moving bodies are searched only if they might be separated on the
//   wrong side: in a heap that forms, a search of every pair costs more than all contacts.
// - Of two bodies that meet, the one that is slow for its own thickness moves on: it gets no deeper than in other
//   steps.
// - A body does not stop at a moving crumb, whose reach is a fraction of its thickness, nor at a much lighter body: a
//   ball among splinters would stand still. Speculative contacts push these bodies (hull_contact.h).
// - The search uses the velocities after contacts, so that a body that bounces off one does not pass through the next.
// - The ground is left out, because its contacts are speculative (ground_contact.h). So are pairs of debris and a
//   moving body.
// - Without a fast body, the cost is one comparison a body.
//
// Rejected: speculative contacts with fixed bodies at any distance. They lose no time, but deflect bodies that pass an
// edge.
//
// Metres, seconds. Not thread-safe; works on several threads itself.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <tuple>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/threads.h"
#include "physics/solver/body.h"
#include "physics/solver/sweep_broadphase.h"
#include "physics/solver/time_of_impact.h"

namespace brittle::physics {

class ContinuousCollision {
  public:
    // A body with less than this part of another body's mass does not stop it.
    static constexpr float light_part = 0.5f;

    // The bounds in the broadphase must be those of the start of the step; find() extends the bounds of crossing bodies
    // by their paths, until they are set again.
    ContinuousCollision(const std::vector<std::unique_ptr<Body>>& bodies, SweepBroadphase& broadphase,
                        fracture::Threads& threads)
        : bodies_(bodies), broadphase_(broadphase), threads_(threads) {}

    struct Stop {
        Body* body;
        float seconds; // of motion, less than the step
        BodyId by;     // the body that it meets
    };
    // Returns the bodies that stop if all awake bodies move for `seconds` from their current poses, in the order of
    // time. Valid until the next call.
    [[nodiscard]] std::span<const Stop> find(std::span<Body* const> awake, float seconds);

  private:
    struct Two {
        uint32_t first, second;
    };
    // The time of impact of two bodies, computed for given stops of each.
    struct Event {
        float seconds;
        uint32_t first, second;
        float first_stop, second_stop;
        // Orders a max-heap with the earliest event on top.
        friend bool operator<(const Event& a, const Event& b) {
            return std::tie(a.seconds, a.first, a.second) > std::tie(b.seconds, b.first, b.second);
        }
    };
    // The data of a body that the search of all bodies reads.
    struct Summary {
        glm::vec3 linear;   // m/s; 0 for a body that does not move
        float way;          // m, longest path of any of its points
        float crossing_way; // m, relative path from which on it may cross a moving body
        bool fixed, awake, debris, fast;
    };

    [[nodiscard]] static bool is_fast(const Body& body, float seconds); // for its thickness
    void find_stops(float seconds);
    [[nodiscard]] static Summary summary_of(const Body& body, float seconds);
    void find_fast(float seconds);
    void find_trajectories(float seconds);           // of all bodies; call it after find_fast()
    void grow_crossing();                            // extends the bounds of crossing bodies
    [[nodiscard]] glm::vec3 common_velocity() const; // mean of awake bodies without debris; 0 if most sleep
    // The bounds of a body along its path.
    [[nodiscard]] Bounds swept(uint32_t body) const;
    // Append pairs of bodies that may touch to kept_: a fast body and fixed ones; a stopped body and moving ones, from
    // a time on; crossing bodies and bodies that are not fixed.
    void pair_with_fixed(uint32_t body);
    void pair_with_moving(uint32_t body, float from);
    void pair_crossing();
    [[nodiscard]] bool may_touch(uint32_t first, uint32_t second, float from) const;
    // Adds the events of the pairs in kept_, from a time on.
    void add_events(float from);
    [[nodiscard]] Event event_of(uint32_t first, uint32_t second, float from) const;
    void stop(uint32_t body, uint32_t by, float seconds);
    [[nodiscard]] bool may_be_stopped(uint32_t body, uint32_t by) const;
    [[nodiscard]] bool is_light(uint32_t body, uint32_t against) const;

    const std::vector<std::unique_ptr<Body>>& bodies_;
    SweepBroadphase& broadphase_;
    fracture::Threads& threads_;
    // Scratch of one call; by body.
    float end_ = 0.0f;
    std::vector<Summary> summaries_;
    std::vector<uint8_t> is_fast_, is_crossing_;
    // In body order. Crossing bodies are fast relative to common_velocity().
    std::vector<uint32_t> fast_, crossing_, fixed_, near_;
    float slow_way_ = 0.0f; // m, longest path of a body that is not crossing
    std::vector<Trajectory> trajectories_;
    std::vector<Two> kept_;     // pairs that may touch
    std::vector<Event> found_;  // by index in kept_
    std::vector<Event> events_; // a heap
    std::vector<Stop> stops_;
};

} // namespace brittle::physics
