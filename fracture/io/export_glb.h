// Pieces out as binary glTF 2.0, one node a piece.
//
// One root node named like the mesh; children `<name>_000` ... with translation = centre of mass and no rotation or
// scale; per piece one mesh, primitive 0 exterior, primitive 1 interior, each with a material of its own. Flat
// shaded: vertices are split per face with normals (glTF has no flat flag), positions on shared edges bit-equal.
// `extras.brittle`: on each child site, volume, area, centre of mass and inertia; on the root the certificate and the
// recipe.
#pragma once

#include <filesystem>
#include <string>

#include "fracture/error.h"
#include "fracture/fragments.h"

namespace brittle::fracture {

struct GlbOptions {
    std::string name = "mesh";   // of the root node and the start of each child's name
    std::string recipe = "{}";   // a JSON object, kept as it is in the root's extras
};

// Atomic: on failure an old file stays as it was. Errors: write_failed; invalid_setting for a recipe that is no JSON.
[[nodiscard]] Result<void> export_glb(const std::filesystem::path& file, const Fragments& fragments,
                                      const Certificate& certificate, const GlbOptions& options = {});

} // namespace brittle::fracture
