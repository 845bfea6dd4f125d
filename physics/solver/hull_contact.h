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
// - All contacts are speculative: they are made before the hulls touch, as far ahead as the two can approach in the
//   step, but no farther than a quarter of the thinner one's thickness, and not by hulls that pass each other in it.
//   Debris has no such limits.
// - The limit holds neither for a body that a much heavier one may pass over in the step, while the two move against
//   each other, nor for two bodies of similar mass that approach by more than it. Their contacts are those of the
//   predicted moment of touch, without rotation.
// - A hull under the facet of a surface (surface_parts.h) presses along directions that the facet allows.
#pragma once

#include <memory>

#include "physics/solver/pair_contacts.h"
#include "physics/solver/transform.h"

namespace brittle::physics {

struct Body;
class HullShape;
struct SurfaceFacet;

// A hull of a body.
struct HullOf {
    const Body* body = nullptr;
    const HullShape* shape = nullptr;
    const Transform* local = nullptr; // of the hull in a compound; null for the only hull
    uint32_t part = 0;
    const SurfaceFacet* facet = nullptr; // of a part of a surface, else null

    [[nodiscard]] Transform frame() const;
};

[[nodiscard]] std::unique_ptr<PairContacts> make_hull_contacts(const HullOf& a, const HullOf& b);

} // namespace brittle::physics
