// Contacts of convex hulls with each other.
//
// Half of the pairs whose boxes overlap in a heap do not touch, and most that touch hardly move
// against each other. Bullet runs GJK for all of them in every step. Here a pair remembers how its hulls
// stood when it last looked closely, and what it saw:
// - a gap: as long as one hull has moved against the other by less than that, there is still none of it gone; then the
//   same direction is tried again, and only where it no longer separates them, GJK looks for another one;
// - contacts that are complete: they follow the bodies until those have moved against each other by
//   a two-hundredth of the smaller one's radius.
// The first is exact: a pair that touches is never passed over. Points, normals and the choice of four points
// are Bullet's, where not said otherwise below.
//
// - Pieces of one cut that fly as one are taken to have a gap without a look (siblings.h).
// - On a hull three times as large, a floor or a wall, what moves has all its lower corners as contacts at once: one a step, and
//   it turns on that, comes down on the next, and goes in corner by corner.
// - Contacts of debris, of what is much lighter than a body that may pass over it in a step (step_stops.h) while they move
//   against each other, and of two of like mass that come closer by a quarter of the thinner one's thickness, are made ahead: as far
//   apart as the two can come closer in that step. But for debris they are made for how the hulls will stand when they touch, turning left out, at
//   several points: the middle of the smaller one's lower corners, the point of touch, and corners far from those, each with its
//   own way to the other hull. Pushed at one point only, what is light would spin, with a third of the speed.
#pragma once

#include <memory>

class btCollisionDispatcher;

namespace brittle::physics {

class HullContacts {
  public:
    // From now on the dispatcher uses it for pairs of hulls, alone or in compounds. Must outlive the
    // dispatcher's pairs.
    explicit HullContacts(btCollisionDispatcher& dispatcher);
    ~HullContacts();

    // Bytes that the dispatcher's pool must have for a pair.
    static int pair_size();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace brittle::physics
