// How the bonds of a piece are shared among the parts that it is cut into.
//
// Points on the area of a bond each go to the part whose hulls are nearest. The share of a part is that of its points,
// and its new bond lies at their centroid. The area of a bond is where the hulls of both pieces reach its plane; where
// they do not, as after a contact in several planes, the whole bond goes to the part that is nearest to its centroid.
//
// Coordinates are those of the graph; metres. Pure functions; thread-safe. Deterministic.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "physics/bonds/bond_graph.h"
#include "physics/world/world.h"

namespace brittle::physics {

struct PlacedHulls {                   // of one piece or part; none of a support
    std::span<const BodyPart> hulls{}; // from the centre
    glm::dvec3 centre{0.0};            // of mass
};

// Returns the shares of all live bonds of a piece, bond by bond, of each bond by part. `hulls_of` gives the hulls of
// the pieces of the graph. Precondition: there are parts, with hulls.
[[nodiscard]] std::vector<BondShare> share_bonds(const BondGraph& graph, uint32_t piece,
                                                 const std::function<PlacedHulls(uint32_t piece)>& hulls_of,
                                                 std::span<const PlacedHulls> parts);

} // namespace brittle::physics
