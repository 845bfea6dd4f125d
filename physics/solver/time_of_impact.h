// The time of impact of two moving hulls within a step.
//
// The narrow phase tests overlap at the ends of steps only. At 2 m/s and 120 Hz a crumb moves by its own size in a
// step: at the next test it is inside a shelf or behind it, and is pushed out on either side. This search follows the
// distance along the path.
//
// Between two times each point moves along a straight line, except for the sag that the body's rotation adds. The gap
// along a fixed direction is therefore a concave function of time, up to that sag, and lies above its chord. Time can
// safely advance to where the chord reaches the depth that is searched for (conservative advancement).
//
// Metres, seconds. Pure functions; thread-safe.
//
// B. Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996, 2.3.
#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "physics/solver/hull_shape.h"
#include "physics/solver/transform.h"
#include "physics/solver/velocity.h"

namespace brittle::physics {

// The motion of a body through a step: constant velocity and torque-free rotation until `stop`, then rest.
struct Trajectory {
    Transform start;
    Velocity velocity;
    glm::dvec3 moments{1.0}; // principal, kg m^2
    float stop = 0.0f;       // s from the start of the step
    Transform end{};         // the frame at `stop`; see find_end()
    float end_known_for = -1.0f;

    // Computes `end`. Call it before at() and after each change of `stop`.
    void find_end();
    [[nodiscard]] Transform at(float seconds) const { return seconds >= stop ? end : moving_at(seconds); }

  private:
    [[nodiscard]] Transform moving_at(float seconds) const;
};

// A hull of a body on its trajectory.
struct MovingHull {
    const HullShape* shape;
    Transform local; // in the body
    const Trajectory* trajectory;
};

// The least width of a hull, from its margin (hull.h).
[[nodiscard]] float thickness(const HullShape& hull);

// The overlap up to which two hulls are separated on the side from which they came: a part of the thinner hull's
// thickness.
[[nodiscard]] float tolerable_depth(const HullShape& first, const HullShape& second);

// Returns the time in [from, end] at which the hulls are about to exceed the tolerable depth, or, if they overlap at
// `from`, that overlap by the tolerable depth. At this time they touch, and the narrow phase finds their contact.
// Returns nothing for hulls that pass each other, slide or part. Precondition: neither body stops between the two
// times.
[[nodiscard]] std::optional<float> time_of_impact(const MovingHull& first, const MovingHull& second, float from,
                                                  float end);

} // namespace brittle::physics
