// Export of the pieces of a fracture to files, by the options of `brittle fracture`.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "fracture/io/export.h"
#include "physics/cutting/hull_meshes.h"
#include "tools/scenario/recipe/input.h"

namespace brittle::tools {

struct ExportSettings {
    std::string output{};   // file whose ending gives the format; empty: no export
    bool per_piece = false; // one file per piece
    bool one_file = false;  // one file for all pieces, also in a format that does not tell them apart
    std::string hulls{}; // "godot" or "unreal": the engine that makes bodies of the pieces by their names; may be empty
    bool rigid_bodies = false;
    uint32_t hull_parts = 0;        // at most, of one piece, for unreal and rigid_bodies; 0: the default
    double density = 0.0;           // kg/m^3, for rigid_bodies; 0: the material's
    std::string interior_texture{}; // image file for the cut faces; empty: none
};

// Throws a Failure for an option of the command line that would have no effect: hulls in a format without nodes, for
// example. `output_option`: that of the file.
void check_export(const ExportSettings& settings, const std::string& output_option);

// Returns the export options that pieces of a fracture and pieces of a running simulation share: looks, names, density.
// The caller sets `per_piece` (splits_files()).
// The result points into `source`. Throws a Failure if the texture cannot be read.
[[nodiscard]] fracture::ExportOptions export_options(const ExportSettings& settings, const FractureOptions& recipe,
                                                     const Input& source);
// Returns whether each of so many pieces gets a file of its own: by the settings, or because the format does not tell
// pieces apart. STL has no groups, and readers that weld it by position lose the faces where pieces touch.
[[nodiscard]] bool splits_files(const ExportSettings& settings, size_t pieces);
// Says on standard error where the files were split because of the format.
void print_split_note(const ExportSettings& settings, const std::vector<std::filesystem::path>& files);
// Returns whether the file will hold collision hulls.
[[nodiscard]] bool wants_hulls(const ExportSettings& settings);
[[nodiscard]] physics::HullMeshSettings hull_settings(const ExportSettings& settings);

// Writes the pieces of a fracture at the places where they were cut, with the recipe. Returns the files written, the
// one to open first. Throws a Failure.
std::vector<std::filesystem::path> write_pieces(const ExportSettings& settings, const FractureOptions& recipe,
                                                const Input& input, const Broken& broken);

} // namespace brittle::tools
