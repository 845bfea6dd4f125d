// The time of impact of two moving hulls within a step.
//
// Overlap is tested at the ends of steps only: at 2 m/s and 120 Hz a crumb moves by its own size in a step, would be
// inside a shelf or behind it at the next test, and would be pushed out on either side. Here the distance is followed
// along the way.
//
// Between two moments each point moves on a straight line but for the body's rotation, so the gap along one direction
// is a concave function of time but for the sag of that rotation. It lies above its chord; where the chord reaches
// the depth that is searched for is how far time may advance (conservative advancement).
//
// Metres, seconds. Thread-safe: no state.
//
// B. Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996, 2.3.
#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "physics/solver/hull_shape.h"
#include "physics/solver/transform.h"
#include "physics/solver/velocity.h"

namespace brittle::physics {

// The free motion of a body through a step: constant velocity, and torque-free rotation, until it stops; then rest.
struct Trajectory {
    Transform start;
    Velocity velocity;
    glm::dvec3 moments{1.0}; // principal
    float stop = 0.0f;       // s from the start of the step
    Transform end{};         // the frame at `stop`; see find_end()
    float end_known_for = -1.0f;

    // Must be called before at(), and after a change of `stop`.
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

// The overlap up to which two hulls are pushed apart on the right side: a part of the thinner one's thickness.
[[nodiscard]] float tolerable_depth(const HullShape& first, const HullShape& second);

// Returns the time between `from` and `end` at which the hulls are about to exceed the tolerable depth, or the depth
// that they have at `from` by that much; they touch there, with their contact still to be found. Returns nothing for
// hulls that pass each other however closely, slide on each other, or part. Neither of the bodies stops between the
// two times.
[[nodiscard]] std::optional<float> time_of_impact(const MovingHull& first, const MovingHull& second, float from,
                                                  float end);

} // namespace brittle::physics
