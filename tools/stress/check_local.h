// Checks cuts of a small part of a mesh (fracture/local) against cuts of the whole.
#pragma once

#include <string>

#include "tools/stress/case.h"

namespace brittle::stress {

// Divides the mesh of a case finely, cuts it near one of its vertices by the sites of the case, drawn together there, and
// returns the first check that fails, or an empty string. Meshes that are not one closed surface pass, and so do cuts
// that only the whole mesh allows.
//  - The pieces are closed and have the volumes of a cut of the whole mesh.
//  - What remains is a closed manifold; its volume and those of the pieces sum to the volume of the mesh.
[[nodiscard]] std::string local_complaint(const Case& c);

} // namespace brittle::stress
