// Contacts of convex hulls with the ground plane.
//
// Bullet finds one contact of a hull with a plane per step and gathers more over time, and only once they
// touch: at 6 m/s and 120 Hz a piece is 5 cm deep in the ground by then, small ones never come up again. Here
// every corner of the hull is looked at, each with the distance it can travel in the coming step: a corner
// that would reach the ground gets its contact before it does, and the solver lets it come just as far.
//
// Four corners carry a hull. Up to eight more that would sink have contacts too: with four, the deepest one and those far from
// it, a piece with two low corners rocks between two choices of four, and each corner sinks while it is not chosen, millimetres
// deep and for ever.
//
// Half of all contacts of a heap are with the ground, so they are kept apart from Bullet's, a point of which has three times the
// size: what a step goes through again and again should fit into the processor's cache.
//
// A limit: the step that ends on the ground does so without a bounce from full speed, so fast impacts on the
// ground bounce less than their restitution says.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "physics/solver/convert.h"
#include "physics/solver/row.h"

class btCollisionDispatcher;
class btCollisionObject;
class btRigidBody;

namespace brittle::physics {

// A corner that touches the ground or may come to it in this step. Bullet's units.
struct alignas(64) GroundPoint {
    std::array<float, 3> position{}; // on the hull, margin included: in the world, when contacts were found
    std::array<float, 3> local{};    // the same in the body's frame; of a compound only
    float distance = 0.0f;           // above the ground, likewise
    int corner = 0;                  // of the hull
    // Of the last solution: the speed at which it came down, the impulse on the hull along +Y, that of friction and where to.
    float speed = 0.0f, impulse = 0.0f, friction = 0.0f;
    std::array<float, 3> along{};
    bool blow = false; // so hard that the next solution does not start from it

    // What became of it; its speed is known.
    void take(float pressed, float rubbed) {
        impulse = pressed;
        friction = rubbed;
        blow = speed > blow_speed * bullet_units;
    }
    [[nodiscard]] float kept_impulse() const { return blow ? 0.0f : impulse; }
    [[nodiscard]] float kept_friction() const { return blow ? 0.0f : friction; }
};

// All of a hull's contacts with the ground.
struct GroundManifold {
    static constexpr uint32_t max_points = 12;

    const btRigidBody* body = nullptr;
    int hull = -1; // of a compound; -1 for the only one
    uint32_t count = 0;
    float friction = 0.0f, restitution = 0.0f; // combined with the ground's
    uint32_t place = 0;                        // among all manifolds
    std::array<GroundPoint, max_points> all{};

    [[nodiscard]] std::span<GroundPoint> points() { return std::span(all).first(count); }
    [[nodiscard]] std::span<const GroundPoint> points() const { return std::span(all).first(count); }
};

class GroundContacts {
  public:
    // From now on the dispatcher uses it for hulls, alone or in a compound, and planes with the normal +Y in
    // a frame without rotation. Must outlive the dispatcher's pairs.
    explicit GroundContacts(btCollisionDispatcher& dispatcher);
    ~GroundContacts();

    // Whether a body of one hull is so high that it has no contact in a step.
    [[nodiscard]] static bool is_out_of_reach(const btRigidBody& body, const btCollisionObject& plane, float seconds);
    // Of all pairs, also of bodies that sleep; some may have no points.
    [[nodiscard]] std::span<GroundManifold* const> manifolds() const;

    // Bytes that the dispatcher's pool must have for a pair.
    static int pair_size();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace brittle::physics
