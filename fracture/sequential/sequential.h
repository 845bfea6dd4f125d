// The paper's Algorithm 1, plane by plane: the readable reference implementation.
//
// "Real Time Voronoi Fracturing of Polygon Meshes": for each site take the whole mesh; for each bisector of the site's
// cell clip every face (clip.h), cap the hole, and continue with the rest; split the rest into islands (islands.h). It
// is never tuned: faster algorithms are compared with it. Its cost grows with triangles times sites.
//
// Promised: every piece is closed and oriented, and volumes sum to the input's, up to rounding. Not promised: equal
// bits on both sides of a cap. Later planes cut a cap, in another order in the cell across, so its two sides have
// different triangles, and a point on several planes may differ in its last bits between cells. Points where one plane
// cuts an edge of the input agree bit for bit; with two sites there are no others.
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

// Algorithm 1. The mesh is closed, positions and sites are finite, and there is at least one site (fracture() has
// checked this). Cells are processed in parallel; the result does not depend on the number of threads. Errors:
// cancelled.
[[nodiscard]] Result<Fragments> fracture_sequential(const HalfEdgeMesh& mesh, std::span<const glm::dvec3> sites,
                                                    const Settings& settings);

} // namespace brittle::fracture
