// Continuous collision: fast bodies stop at their time of impact (time_of_impact.h), in front of what they hit.
//
// A body that moves by a quarter of its own thickness in a step has its way searched for other bodies. Where it
// touches one it stops for the rest of the step and keeps its velocity; the next step finds the contact and all of
// the speed, so that a blow is one impulse and a bounce has its height. Bodies that pass without touching, slide or
// part are left alone, bit for bit.
//
// - No body passes through a fixed one. Two moving bodies are searched only when they might come out on each other's
//   wrong side: in a heap that forms, a search of every pair costs more than all contacts.
// - Of two bodies that meet, one that is slow for its own thickness goes on: it gets no deeper than in any other step.
// - A body does not stop at a moving crumb that fits into it many times, nor at a much lighter body: a ball among
//   splinters would stand still. It drives them before it, by speculative contacts (hull_contact.h).
// - The velocities are those after contacts, so that a body that bounces off one does not pass through the next.
// - The ground is left out, because its contacts are speculative (ground_contact.h), and so are moving bodies beside
//   debris.
// - Without a fast body, a body costs one comparison.
//
// Rejected: speculative contacts for fixed bodies as well. No time is lost then, but a blow falls on two steps in two
// parts, and what flies past an edge is deflected.
//
// Metres, seconds. Not thread-safe, but works on several threads itself.
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
    // A body with less than this part of another's mass does not stop it.
    static constexpr float light_part = 0.5f;
    // A body that reaches this many times as far as another is a floor or a wall to it.
    static constexpr float larger_factor = 3.0f;

    // Bodies by their index. The bounds in the broadphase must be those of the start of the step; those of some
    // moving bodies grow by their way, until they are set anew.
    ContinuousCollision(const std::vector<std::unique_ptr<Body>>& bodies, SweepBroadphase& broadphase,
                        fracture::Threads& threads)
        : bodies_(bodies), broadphase_(broadphase), threads_(threads) {}

    struct Stop {
        Body* body;
        float seconds; // that it moves, less than the step
    };
    // The bodies that stop when all that are awake move on for so long from where they are, in the order of time.
    // Valid until the next call.
    [[nodiscard]] std::span<const Stop> find(std::span<Body* const> awake, float seconds);

  private:
    struct Two {
        uint32_t first, second;
    };
    // The time of impact of two bodies, given when each of them stops.
    struct Event {
        float seconds;
        uint32_t first, second;
        float first_stop, second_stop;
        // The earliest is on top of a heap.
        friend bool operator<(const Event& a, const Event& b) {
            return std::tie(a.seconds, a.first, a.second) > std::tie(b.seconds, b.first, b.second);
        }
    };
    // What the search reads of every body.
    struct Summary {
        glm::vec3 linear;   // 0 of a body that does not move
        float way;          // m, the longest of any of its points
        float crossing_way; // m, from which on it may cross a moving body
        bool fixed, awake, debris, fast;
    };

    [[nodiscard]] static bool is_fast(const Body& body, float seconds); // for its thickness
    void find_stops(float seconds);
    [[nodiscard]] static Summary summary_of(const Body& body, float seconds);
    void find_fast(float seconds);
    void find_trajectories(float seconds);           // of all bodies, after the fast ones are known
    void grow_crossing();                            // their bounds
    [[nodiscard]] glm::vec3 common_velocity() const; // of most bodies that can move, debris left out
    // Bounds that hold a body on its way.
    [[nodiscard]] Bounds swept(uint32_t body) const;
    // These keep pairs of bodies that may touch: a fast one and fixed ones; one that has stopped and moving ones,
    // from a time on; crossing ones and others that are not fixed.
    void pair_with_fixed(uint32_t body);
    void pair_with_moving(uint32_t body, float from);
    void pair_crossing();
    [[nodiscard]] bool may_touch(uint32_t first, uint32_t second, float from) const;
    // Adds the events of the pairs that were kept, from a time on.
    void add_events(float from);
    [[nodiscard]] Event event_of(uint32_t first, uint32_t second, float from) const;
    void stop(uint32_t body, float seconds);
    [[nodiscard]] bool may_be_stopped(uint32_t body, uint32_t by) const;
    [[nodiscard]] bool is_light(uint32_t body, uint32_t against) const;

    const std::vector<std::unique_ptr<Body>>& bodies_;
    SweepBroadphase& broadphase_;
    fracture::Threads& threads_;
    // Scratch of one call; by body.
    float end_ = 0.0f;
    std::vector<Summary> summaries_;
    std::vector<uint8_t> is_fast_, is_crossing_;
    // In body order. Crossing bodies are fast against most others.
    std::vector<uint32_t> fast_, crossing_, fixed_, near_;
    float slow_way_ = 0.0f; // m, the longest of a body that is not crossing
    std::vector<Trajectory> trajectories_;
    std::vector<Two> kept_;     // pairs that may touch
    std::vector<Event> found_;  // by their place in kept_
    std::vector<Event> events_; // a heap
    std::vector<Stop> stops_;
};

} // namespace brittle::physics
