// Bodies that end their step where they first touch another one, and not behind it: first_touch.h.
//
// A body that moves by a quarter of its own thickness in a step is looked at on its way: what is near it, and when it touches.
// There it stops for the rest of the step, with its velocity as it is; the next step finds the contact and all of its speed,
// so that a blow has one impulse, whole, and a bounce its height. What passes without touching, however near, and what slides
// or parts is left alone, bit for bit.
//
// - Fixed bodies are not passed by anything. Two that move are looked at only when they might come out on each other's wrong
//   side: in a heap that forms, nobody sees it, and looking costs more than all contacts.
// - Of what is not much lighter, contacts are made ahead as well where hulls, not compounds, meet faster than a quarter of the
//   thinner one's thickness a step: they leave little that would pass. Blows are then summed up over their steps
//   (contact_blows.h, bond_blows.h).
// - Of two that meet, who is slow for its own thickness goes on: it gets no deeper into the other than it would in any step.
// - A body does not wait for a moving crumb that fits into it many times, nor for what is much lighter: a ball that flies
//   through splinters would stand still among them. It drives them before it, by contacts that are made ahead
//   (hull_contact.cpp).
// - Velocities are those after contacts, so that what bounces off one body does not pass through the next.
// - The ground is left out: its contacts look ahead (ground_contact.h). So do those of debris with what moves: neither stops
//   the other.
// - While nothing is fast, a body costs a comparison.
//
// Contacts that are made ahead of the touch, and take from the speed what exceeds gap over time, were weighed: no time is
// lost, but a blow comes in two parts, in two steps, and what flies past an edge is turned where the contact is not made for where
// the two will touch (hull_contact.cpp). Against what is fixed all of the speed in one step is worth more.
//
// Bullet's units. Not thread-safe, but works on several threads itself.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <tuple>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include "fracture/base/parallel.h"
#include "physics/solver/body_record.h"
#include "physics/solver/first_touch.h"
#include "physics/solver/sweep_broadphase.h"

namespace brittle::physics {

class StepStops {
  public:
    // What has less than this part of a body's mass does not stop it.
    static constexpr btScalar light_part = 0.5f;
    // What reaches so many times as far as a body is a floor or a wall to it.
    static constexpr btScalar larger_factor = 3.0f;

    // Bodies by their user indices. Boxes in the broadphase must be those of the step's beginning; some of what moves are
    // grown by its way, until they are set anew.
    StepStops(const std::vector<std::unique_ptr<BodyRecord>>& bodies, SweepBroadphase& broadphase,
              fracture::Threads& threads)
        : bodies_(bodies), broadphase_(broadphase), threads_(threads) {}

    struct Box {
        btVector3 low, high;
    };
    struct Stop {
        BodyRecord* body;
        btScalar seconds; // that it moves, less than the step
    };
    // Who stops when all that are awake move on for so long from where they are, in the order of time. Valid until the next
    // call.
    [[nodiscard]] std::span<const Stop> find(std::span<BodyRecord* const> awake, btScalar seconds,
                                             btDispatcher& dispatcher);

  private:
    struct Two {
        uint32_t first, second;
    };
    // When two bodies touch, as far as it is known who of them stops before.
    struct Event {
        btScalar seconds;
        uint32_t first, second;
        btScalar first_stop, second_stop;
        // The earliest is on top of a heap.
        friend bool operator<(const Event& a, const Event& b) {
            return std::tie(a.seconds, a.first, a.second) > std::tie(b.seconds, b.first, b.second);
        }
    };

    // What is asked of every body.
    struct Glance {
        btVector3 linear;  // 0 of one that does not move
        btScalar way;      // the longest of any of its points
        btScalar wild_way; // from which on it is wild
        bool fixed, awake, debris, fast;
    };

    [[nodiscard]] static bool is_fast(const BodyRecord& body, btScalar seconds); // for its thickness
    void find_stops(btScalar seconds, btDispatcher& dispatcher);
    [[nodiscard]] static Glance glance_at(const BodyRecord& body, btScalar seconds);
    void find_fast(btScalar seconds);
    void find_flights(btScalar seconds);             // of all, after who is fast
    void swell_wild(btDispatcher& dispatcher);       // their boxes
    [[nodiscard]] btVector3 common_velocity() const; // of most that can move, without debris
    // What holds a body on its way.
    [[nodiscard]] Box swept(uint32_t body) const;
    // These keep whom a body may touch, from a time on: of those that are fixed; of the others.
    void meet_fixed(uint32_t body);
    void meet_moving(uint32_t body, btScalar from);
    // Whom those that are wild may touch that are not fixed.
    void meet_wild();
    [[nodiscard]] bool may_touch(uint32_t first, uint32_t second, btScalar from) const;
    // Adds the events of the two that were kept, from a time on.
    void add_events(btScalar from);
    [[nodiscard]] Event event_of(uint32_t first, uint32_t second, btScalar from) const;
    void stop(uint32_t body, btScalar seconds);
    [[nodiscard]] bool may_be_stopped(uint32_t body, uint32_t by) const;
    [[nodiscard]] bool is_light(uint32_t body, uint32_t against) const;

    const std::vector<std::unique_ptr<BodyRecord>>& bodies_;
    SweepBroadphase& broadphase_;
    fracture::Threads& threads_;
    // Scratch of one call; bodies by index.
    btScalar end_ = 0.0f;
    std::vector<Glance> glances_;
    std::vector<uint8_t> is_fast_, is_wild_;
    std::vector<uint32_t> fast_,
        wild_; // in body order; those that move fast, and those that move fast against most others
    std::vector<uint32_t> fixed_, near_;
    btScalar slow_way_ = 0.0f; // the longest way of those that are not wild
    std::vector<Flight> flights_;
    std::vector<Two> kept_;     // who may touch
    std::vector<Event> found_;  // by their place
    std::vector<Event> events_; // a heap
    std::vector<Stop> stops_;
};

} // namespace brittle::physics
