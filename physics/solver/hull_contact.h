// Contacts of two convex hulls, each alone in its body or one of a compound.
//
// Half of the pairs whose bounds overlap in a heap do not touch, and most pairs that touch hardly move against each
// other. A pair therefore remembers the relative pose in which it last searched, and what it found:
// - a gap: until one hull has moved against the other by less than the gap, there is still some of it left; then the
//   same direction is tried again, and GJK (hull_distance.h) only where that direction does not separate them any
//   more;
// - complete contacts: they follow the bodies until those have moved against each other by a two-hundredth of the
//   smaller hull's radius.
// The first is exact: a pair that touches is never missed.
//
// - Pieces of one cut that fly as one are taken to have a gap (siblings.h).
// - On a hull three times as large, a floor or a wall, a moving hull has all its lower corners as contacts at once.
//   With one a step it turns on that corner, comes down on the next, and sinks in corner by corner.
// - Speculative contacts, made before the hulls touch and as far ahead as the two can come closer in the step: of
//   debris; of a body that a much heavier one may pass over in the step, while the two move against each other; and
//   of two bodies of similar mass that come closer by a quarter of the thinner one's thickness. Except for debris
//   they are made for the predicted moment of touch, rotation left out, at several points: the point of touch, the
//   middle of the smaller hull's lower corners, and the corners farthest from these, each with its own gap. Pushed at
//   one point only, a light body would spin and take a third of the speed.
#pragma once

#include <memory>

#include "physics/solver/pair_contacts.h"
#include "physics/solver/transform.h"

namespace brittle::physics {

struct Body;
class HullShape;

// A hull of a body.
struct HullOf {
    const Body* body = nullptr;
    const HullShape* shape = nullptr;
    const Transform* local = nullptr; // of the hull in a compound; null for the only hull
    uint32_t part = 0;

    [[nodiscard]] Transform frame() const;
};

[[nodiscard]] std::unique_ptr<PairContacts> make_hull_contacts(const HullOf& a, const HullOf& b);

} // namespace brittle::physics
