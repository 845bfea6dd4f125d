// Options that several commands share. Each function adds one group to a command and binds it to a struct, which must
// outlive the parsing.
//
// CLI11 applies options in the order in which they were added. add_fracture_options() adds --recipe first, so that
// options on the command line override the recipe.
#pragma once

#include <functional>
#include <string>

#include <CLI/CLI.hpp>

#include "tools/brittle/commands/commands.h"

namespace brittle::tools {

// The help of a positional MESH, with all file endings and shapes.
[[nodiscard]] std::string mesh_help();

// Mesh, recipe, pattern, sites and algorithm.
void add_fracture_options(CLI::App& command, FractureOptions& options);
// --pieces-from, for commands that play scenes. After add_fracture_options().
void add_pieces_option(CLI::App& command, FractureOptions& options);
// The physics of the pieces after the fracture.
void add_world_options(CLI::App& command, WorldOptions& world);
// Size, device, quality and validation of pictures or a window.
void add_view_options(CLI::App& command, ViewOptions& view);
void add_threads_option(CLI::App& command, uint32_t& threads);
void add_classify_option(CLI::App& command, std::string& processor);
void add_record_option(CLI::App& command, std::string& file);

// Contents of the files that pieces are written to, without the output itself.
void add_export_options(CLI::App& command, ExportSettings& files);
// --export, to `output`, and --export-as, with the options of add_export_options().
void add_state_export(CLI::App& command, std::string& output, ExportSettings& pieces);
// Whether the command line gives an option, after parsing. The command must outlive the function.
[[nodiscard]] std::function<bool(const std::string& option)> given_options(const CLI::App& command);
// Returns the settings that have an effect on the file (piece_export.h), and tells of those of a recipe that have none.
[[nodiscard]] ExportSettings settle_export(const CLI::App& command, const ExportSettings& settings,
                                           const std::string& output, const std::string& output_option);
// Refuses a file whose ending names no format that pieces can be written in.
[[nodiscard]] std::string check_export_ending(const std::string& file);

} // namespace brittle::tools
