// The facets of an arrangement, and the winding numbers of the space on both sides of them.
//
// A facet is a triangle that meets others in corners and edges only. Triangles with equal corners are one facet; its
// multiplicity is the number of those with its orientation, minus the others. A path through a facet from its front to
// its back gains the multiplicity in winding number.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fracture/unite/arrangement.h"

namespace brittle::fracture::arrangement {

struct Facet {
    Triangle points;
    int multiplicity;
    std::array<uint32_t, 2> source; // a triangle of the mesh with this orientation, and one with the other; or no_index
    int front = 0;                  // winding number

    [[nodiscard]] int back() const { return front + multiplicity; }
};

// Returns the facets of an arrangement: `parts` (divide_triangles()) and the triangles that are not cut, in the order of
// the mesh. Triangles without area give none. The mesh is closed: as many triangles run along an edge in one direction
// as in the other.
[[nodiscard]] std::vector<Facet> find_facets(Arrangement& arrangement, const std::vector<Part>& parts,
                                             Threads& threads);

} // namespace brittle::fracture::arrangement
