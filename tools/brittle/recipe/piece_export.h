// Export of the pieces of a fracture to files, by the options of `brittle fracture`.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "fracture/io/export.h"
#include "physics/world/hull.h"
#include "tools/brittle/recipe/input.h"

namespace brittle::tools {

struct ExportSettings {
    std::string output{};   // file whose ending gives the format; empty: no export
    bool per_piece = false; // one file per piece
    std::string hulls{};    // "godot" or "unreal": naming scheme of collision hulls; empty: no hulls
    bool rigid_bodies = false;
    double density = 0.0;           // kg/m^3, for rigid_bodies; 0: the material's
    std::string interior_texture{}; // image file for the cut faces; empty: none
};

// Returns the export options that pieces of a fracture and pieces of a running simulation share: looks, names, density.
// The result points into `source`. Throws a Failure if the texture cannot be read.
[[nodiscard]] fracture::ExportOptions export_options(const ExportSettings& settings, const FractureOptions& recipe,
                                                     const Input& source);
// Returns whether the settings include collision hulls.
[[nodiscard]] bool wants_hulls(const ExportSettings& settings);

// Returns the collision hull of a piece as a mesh, in the coordinates of the fragments. `planes` are those of its
// contacts, see physics::contact_planes(), along which the hulls of rough pieces are cut.
[[nodiscard]] fracture::TriangleMesh collision_mesh(const fracture::Fragments& fragments, const fracture::Piece& piece,
                                                    std::span<const physics::HullPlane> planes);

// Writes the pieces of a fracture at the places where they were cut, with the recipe. Returns the files written, the
// one to open first. Throws a Failure.
std::vector<std::filesystem::path> write_pieces(const ExportSettings& settings, const FractureOptions& recipe,
                                                const Input& input, const Broken& broken);

} // namespace brittle::tools
