// Export of the pieces of a fracture to files, by the options of `brittle fracture`.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "fracture/io/export.h"
#include "physics/cutting/hull_meshes.h"
#include "tools/scenario/recipe/export_settings.h"
#include "tools/scenario/recipe/input.h"

namespace brittle::tools {

// Returns the settings without those of a recipe that have no effect on the file: hulls in a format without nodes, for
// example. Throws a Failure for one that the command line gives. `output_option`: that of the file. `given`: whether the
// command line gives an option, such as "--hulls". `notes` tells people what is left out. It stays empty where no file
// is written.
[[nodiscard]] ExportSettings effective_export(ExportSettings settings, const std::string& output_option,
                                              const std::function<bool(const std::string& option)>& given,
                                              std::vector<std::string>& notes);

// Returns the settings of a recipe, overridden by those that the command line gives. `given` as in effective_export().
[[nodiscard]] ExportSettings overridden_export(ExportSettings recipe, const ExportSettings& line,
                                               const std::function<bool(const std::string& option)>& given);

// Returns the export options that pieces of a fracture and pieces of a running simulation share: looks, names, density.
// The caller sets `per_piece` (splits_files()).
// The result points into `source`. Throws a Failure if the texture cannot be read.
[[nodiscard]] fracture::ExportOptions export_options(const ExportSettings& settings, const FractureOptions& recipe,
                                                     const Input& source);
// Returns whether each of so many pieces gets a file of its own: by the settings, or because the format does not tell
// pieces apart. STL has no groups, and readers that weld it by position lose the faces where pieces touch.
[[nodiscard]] bool splits_files(const ExportSettings& settings, size_t pieces);
// Returns whether the file will hold collision hulls.
[[nodiscard]] bool wants_hulls(const ExportSettings& settings);
[[nodiscard]] physics::HullMeshSettings hull_settings(const ExportSettings& settings);

// Writes the pieces of a fracture at the places where they were cut, with the recipe. Returns the files written, the
// one to open first. Throws a Failure.
std::vector<std::filesystem::path> write_pieces(const ExportSettings& settings, const FractureOptions& recipe,
                                                const Input& input, const Broken& broken);

// Returns the one file of the pieces in the format ExportSettings::stream; an OBJ file names no materials of an MTL file.
// Throws a Failure.
[[nodiscard]] std::vector<std::byte> pieces_in_memory(const ExportSettings& settings, const FractureOptions& recipe,
                                                      const Input& input, const Broken& broken);

} // namespace brittle::tools
