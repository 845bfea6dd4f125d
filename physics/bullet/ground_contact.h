// Contacts of convex hulls with the ground plane.
//
// Bullet finds one contact of a hull with a plane per step and gathers more over time, and only once they
// touch: at 6 m/s and 120 Hz a piece is 5 cm deep in the ground by then, small ones never come up again. Here
// every corner of the hull is looked at, each with the distance it can travel in the coming step: a corner
// that would reach the ground gets its contact before it does, and the solver lets it come just as far.
//
// Four corners carry a hull. Up to eight more that would sink have contacts too, in manifolds of their own: with four,
// the deepest one and those far from it, a piece with two low corners rocks between two choices of four, and each
// corner sinks while it is not chosen, millimetres deep and for ever.
//
// A limit: the step that ends on the ground does so without a bounce from full speed, so fast impacts on the
// ground bounce less than their restitution says.
#pragma once

#include <memory>

class btCollisionDispatcher;

namespace brittle::physics {

class GroundContacts {
  public:
    // From now on the dispatcher uses it for hulls, alone or in a compound, and planes with the normal +Y in
    // a frame without rotation. Must outlive the dispatcher's pairs.
    explicit GroundContacts(btCollisionDispatcher& dispatcher);
    ~GroundContacts();

    // Bytes that the dispatcher's pool must have for a pair.
    static int pair_size();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace brittle::physics
