// Mends flaws that modelling programs leave, where it is asked for. Import never repairs on its own.
#pragma once

#include <cstdint>

#include "fracture/mesh.h"

namespace brittle::fracture {

struct Repair {
    TriangleMesh mesh;
    uint32_t removed_triangles = 0;
    uint32_t removed_patches = 0; // connected groups of them
};

// Removes patches that cover a place which is covered already, so that three triangles meet along their rims.
// Poorly merged quads are the usual case: one quad split along both diagonals, four triangles where two
// belong (the horse of glmark2 has six of them).
//
// A patch is what stays connected when the mesh is cut along all edges that are not used exactly twice. It is
// spare when it uses each edge of its rim once, each of them remains used in both directions without it, and
// fewer edges are then used more often in one direction than in the other. So a solid that touches itself or
// another along an edge loses nothing, while an inner wall goes. Where several patches could go, one with
// misoriented edges inside goes first, then the one with fewer triangles, then the one later in the file.
// Positions and order stay; a mesh without spare patches comes back as it is. Deterministic, O(T log T).
[[nodiscard]] Repair remove_spare_patches(const TriangleMesh& mesh);

} // namespace brittle::fracture
