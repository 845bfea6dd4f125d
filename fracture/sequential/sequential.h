// The paper's Algorithm 1, plane by plane: the readable reference.
//
// "Real Time Voronoi Fracturing of Polygon Meshes": for each site take the whole mesh; for each bisector of
// the site's cell clip every face (clip.h), cap the hole, and go on with what is left; split the rest into
// islands (islands.h). Never tuned: it is what faster algorithms are compared with. Its cost grows with
// triangles times sites.
//
// What it promises: every piece is closed and oriented, and volumes sum to the input's up to rounding. What
// it cannot: a cap is cut by the planes that follow it, and these come in another order in the cell across,
// so the two sides of a cap are triangulated differently, and a point that several planes cut out may differ
// in its last bits between cells. Points where one plane cuts an edge of the input agree bit for bit, so with
// two sites all do.
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "fracture/mesh/half_edge.h"
#include "fracture/pieces/fragments.h"
#include "fracture/sequential/bisectors.h"
#include "fracture/settings.h"

namespace brittle::fracture {

// The part of a closed mesh in the cell of one site: the inner loop of Algorithm 1.
[[nodiscard]] HalfEdgeMesh cut_cell(const HalfEdgeMesh& mesh, std::span<const Bisector> bisectors, uint32_t site);

// Algorithm 1. The mesh is closed, positions and sites are finite, there is a site (fracture() has checked).
// Cells are worked on side by side; the result does not depend on how many at a time. Errors: cancelled.
[[nodiscard]] Result<Fragments> fracture_sequential(const HalfEdgeMesh& mesh, std::span<const glm::dvec3> sites,
                                                    const Settings& settings);

} // namespace brittle::fracture
