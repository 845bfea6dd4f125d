// Pieces out as binary glTF 2.0, one node a piece.
//
// One root node named like the mesh; children `<name>_000` ... with translation = centre of mass and no
// rotation or scale; per piece one mesh, primitive 0 exterior, primitive 1 interior, each with a material of
// its own. A piece without exterior triangles has the interior primitive only, and the other way round: tell
// them by material.
//
// Flat shaded: glTF has no flag for it, so vertices are split where the plane changes. Triangles of one
// triangle_source and one plane share vertices and a normal; slivers thus get the normal of their plane. The interior has
// texture coordinates in metres (attributes.h) where the sites are given.
//
// Positions are 32-bit floats: float(position - translation), with the translation first rounded to float, so
// that translation + position is the closest that two floats come to the original. Within a piece equal
// positions stay equal bit for bit, also between its two primitives: a reader that welds by position gets the
// closed piece back. Between neighbours they agree only to rounding, because each is relative to its own
// centre.
//
// `extras.brittle` holds on each child site, volume, area, centre_of_mass, inertia (at density 1 about the
// centre of mass, row by row: xx xy xz yx yy yz zx zy zz) and the counts of exterior_triangles and
// interior_triangles; on the root the certificate and the recipe. Hashes are strings, because JSON numbers
// have 53 bits. Equal input gives equal bytes.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include <glm/vec3.hpp>

#include "fracture/error.h"
#include "fracture/fragments.h"

namespace brittle::fracture {

struct GlbOptions {
    std::string name = "mesh"; // of the root node and the start of each child's name
    std::string recipe = "{}"; // a JSON object, kept as it is in the root's extras
    std::span<const glm::dvec3> sites{}; // of the fracture, for texture coordinates on the cuts; or none
};

// Atomic: on failure an old file stays as it was. Errors: write_failed, also for output of 4 GiB and more,
// which the format cannot hold, and for coordinates that do not fit a float; invalid_setting for a recipe
// that is no JSON object.
[[nodiscard]] Result<void> export_glb(const std::filesystem::path& file, const Fragments& fragments,
                                      const Certificate& certificate, const GlbOptions& options = {});

} // namespace brittle::fracture
