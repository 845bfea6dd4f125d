// Checks of a union by oracles that share no code with it.
#pragma once

#include <string>

#include "tools/stress/case.h"

namespace brittle::stress {

// Unites the mesh of a case and returns the first check that fails, or an empty string. Meshes that are not closed and
// oriented pass.
//  - The result is a closed, oriented manifold, complete, and another union changes no bit of it.
//  - The surface winds once around random points of the region with a winding number above 0, and around no others, by
//    the sum of solid angles.
//  - Another number of threads gives equal bits.
[[nodiscard]] std::string union_complaint(const Case& c);

// Returns the winding number of the surface around a point: the sum of the solid angles of its triangles over 4 pi (Van
// Oosterom and Strackee, "The solid angle of a plane triangle", 1983). An integer up to rounding, except at the surface.
[[nodiscard]] double winding_number(const fracture::TriangleMesh& mesh, const glm::dvec3& point);

} // namespace brittle::stress
