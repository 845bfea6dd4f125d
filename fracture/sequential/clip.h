// Cuts a closed half-edge mesh along a bisector and caps the cut.
//
// "Real Time Voronoi Fracturing of Polygon Meshes", sections 2.2 to 2.4: each face is one of eight cases, by the
// corners that the cell keeps (eq. 8-13); a walk along the BORDER half-edges of the rim finds its loops (2.3); the
// loops are triangulated into a cap (2.4).
//
// The result is closed by construction: the two triangles of a crossing edge share one new vertex, so each new vertex
// has exactly one incoming and one outgoing BORDER half-edge, and loops always close. No tolerance decides anything: a
// vertex on the plane belongs to one fixed side (bisectors.h). The edges without length and faces without area that
// follow from this stay in the closed mesh, where they do no harm.
#pragma once

#include <cstdint>

#include "fracture/mesh/half_edge.h"
#include "fracture/sequential/bisectors.h"

namespace brittle::fracture {

// The case of a triangle abc, by the corners that are kept: bit 0 for a, bit 1 for b, bit 2 for c.
enum class CutCase : uint8_t {
    none = 0, // the face is dropped
    a = 1,    // one corner stays: a triangle
    b = 2,
    ab = 3, // two corners stay: a quad, cut in two triangles
    c = 4,
    ca = 5,
    bc = 6,
    abc = 7 // the face stays
};

[[nodiscard]] constexpr CutCase cut_case(bool a, bool b, bool c) {
    return static_cast<CutCase>((a ? 1 : 0) | (b ? 2 : 0) | (c ? 4 : 0));
}

// The point where an edge pq meets the plane (eq. 8-13): p + lambda (q - p) with lambda = g(p) / (g(p) - g(q)) in [0,
// 1]. Symmetric in p and q: the computation starts at the lexicographically smaller end, so both triangles and the
// cells on both sides of the plane get the same bits. p and q lie on different sides.
[[nodiscard]] glm::dvec3 intersection(const glm::dvec3& p, const glm::dvec3& q, const Bisector& plane);

// Whether the convex quad pqrs is better cut along pr than along qs (eq. 14): along the Delaunay diagonal, which joins
// the corners with the larger sum of angles and makes the smallest angle of the two triangles as large as possible. The
// angles are measured in the plane of the quad.
[[nodiscard]] bool cut_along_first_diagonal(const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r,
                                            const glm::dvec3& s);

// The part of a closed mesh on the given site's side of the plane, closed by caps. Faces inherit their source; caps are
// interior, with the site across the plane as source. Vertices that stay keep their order and their bits. Empty if no
// vertex stays.
[[nodiscard]] HalfEdgeMesh clip(const HalfEdgeMesh& mesh, const Bisector& plane, uint32_t site);

} // namespace brittle::fracture
