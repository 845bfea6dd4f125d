// Contacts of two convex hulls, each the only hull of its body or one of a compound.
//
// Half of the pairs whose bounds overlap in a heap do not touch, and most pairs that touch hardly move against each
// other. A pair therefore keeps the relative pose of its last search, and the result:
// - A gap. The hulls cannot touch before they have moved against each other by as much as the gap. Then the last
//   separating direction is tried first, and GJK (hull_distance.h) runs only if it no longer separates them. This is
//   exact: no touching pair is missed.
// - Complete contacts. They follow the bodies until these have moved against each other by a two-hundredth of the
//   smaller hull's radius.
//
// Special cases:
//
// - Siblings that move as one count as having a gap (siblings.h).
// - On a hull three times as large, a floor or a wall, all lower corners of a moving hull become contacts at once. With
//   one new contact a step it would turn on that corner, come down on the next, and sink in corner by corner.
// - Speculative contacts are made before the hulls touch, as far ahead as the two can approach in the step. Debris has
//   them; a body that a much heavier one may pass over in the step, while the two move against each other; and two
//   bodies of similar mass that approach by a quarter of the thinner one's thickness. Except for debris they are placed
//   for the predicted moment of touch, without rotation, at several points: the point of touch, the middle of the
//   smaller hull's lower corners, and the corners farthest from these, each with its own gap. Pushed at one point only,
//   a light body would spin and take a third of the speed.
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
