// Pieces into files, as the options of `brittle fracture` say.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fracture/io/export.h"
#include "tools/brittle/recipe/input.h"

namespace brittle::tools {

struct ExportSettings {
    std::string output{};   // its ending says the format; empty: nothing is written
    bool per_piece = false; // a file for each
    std::string hulls{};    // "godot" or "unreal": how collision hulls are named; empty: none
    bool rigid_bodies = false;
    double density = 0.0;           // kg/m^3, of rigid_bodies; 0: the material's
    std::string interior_texture{}; // an image for the cuts; empty: none
};

// What both kinds of pieces have in common: looks, names, density. It points into `source`. Throws a Failure where the
// texture cannot be read.
[[nodiscard]] fracture::ExportOptions export_options(const ExportSettings& settings, const FractureOptions& recipe,
                                                     const Input& source);
// Whether the settings ask for hulls.
[[nodiscard]] bool wants_hulls(const ExportSettings& settings);

// The hull of one piece as a mesh, in its coordinates.
[[nodiscard]] fracture::TriangleMesh collision_mesh(const fracture::Fragments& fragments, const fracture::Piece& piece);

// The pieces of a fracture where they were cut, with the recipe. The files written, the one to open first. Throws a Failure.
std::vector<std::filesystem::path> write_pieces(const ExportSettings& settings, const FractureOptions& recipe,
                                                const Input& input, const Broken& broken);

} // namespace brittle::tools
