// Who touches whom after a fracture: a bond for each pair of pieces that share a cap.
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "fracture/fragments.h"

namespace brittle::fracture::exact {

// Fills out.bonds, ordered by (a, b), from pieces, triangle_source and vertex_point; only directions between
// sites matter. Several caps between two pieces (a facet cut into separate regions) make one bond; caps
// without area make none.
void find_bonds(std::span<const glm::dvec3> sites, Fragments& out);

} // namespace brittle::fracture::exact
