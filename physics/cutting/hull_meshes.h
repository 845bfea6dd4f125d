// The collision hulls of pieces as meshes, for files and for other physics engines.
//
// A piece that is far from convex has several hulls (convex_parts.h). The hulls of two pieces do not overlap: those of
// a Voronoi cell's parts stay inside the cell, and those of rough pieces are cut along their contacts. Two islands of
// one cell may overlap.
//
//     const std::vector<std::vector<TriangleMesh>> hulls = hull_meshes(fragments);
//     must(export_pieces("pieces.glb", fragments, certificate, {.hulls = hulls, .rigid_bodies = true}));
//
// Metres, in the coordinates of the fragments. Pure functions; equal input gives equal hulls.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "physics/world/hull.h"

namespace brittle::physics {

struct HullMeshSettings {
    // Bound of the hulls of one piece, at least 1. A piece gets fewer as soon as each hull is at most 1.25 times as
    // large as the part that it encloses.
    uint32_t max_parts = 16;
    uint32_t max_vertices = 32; // of one hull, at least 8
};

// Returns the convex hull of points as a closed mesh, without the corners that reach less than 5 thousandths of the
// longest extent beyond the hull of the others. Fewer than 4 points, or coplanar ones, may give an empty mesh.
[[nodiscard]] fracture::TriangleMesh plain_hull(std::span<const glm::vec3> points);

// Returns the hulls of one piece. `planes`: those of its contacts, see contact_planes().
[[nodiscard]] std::vector<fracture::TriangleMesh> hull_meshes(const fracture::Fragments& fragments,
                                                              const fracture::Piece& piece,
                                                              std::span<const HullPlane> planes,
                                                              const HullMeshSettings& settings = {});

// Returns the hulls of each piece. It uses `threads` threads (0: one a core); the result does not depend on their
// number.
[[nodiscard]] std::vector<std::vector<fracture::TriangleMesh>>
hull_meshes(const fracture::Fragments& fragments, const HullMeshSettings& settings = {}, uint32_t threads = 0);

} // namespace brittle::physics
