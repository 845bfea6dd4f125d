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

// The help lists the options that are added from now on under this heading.
void start_group(CLI::App& command, const std::string& heading);

// The help of a positional MESH, with all file endings and shapes.
[[nodiscard]] std::string mesh_help();
// --format, of a mesh on standard input.
void add_format_option(CLI::App& command, std::string& format);
// Refuses --format without the mesh "-", and the mesh "-" with options whose files would have to name it. After parsing.
void check_standard_input(const CLI::App& command, const std::string& mesh);
// Refuses the mesh "-", for commands that read a mesh several times. After parsing.
void refuse_standard_input(const CLI::App& command, const std::string& mesh);

// --quiet, --json unless null, and --help under a heading of their own. After all other options.
void add_general_options(CLI::App& command, bool* json);

// Mesh, recipe, pattern, sites and algorithm.
void add_fracture_options(CLI::App& command, FractureOptions& options);
// Returns the recipe that the command line names, which gave the options; or "". After parsing.
[[nodiscard]] std::string recipe_file(const CLI::App& command);
// --pieces-from, for commands that play scenes. After add_fracture_options().
void add_pieces_option(CLI::App& command, FractureOptions& options);
// The physics of the pieces after the fracture.
void add_world_options(CLI::App& command, WorldOptions& world);
// Size and quality of pictures or a window, device and validation.
void add_view_options(CLI::App& command, ViewOptions& view);
void add_threads_option(CLI::App& command, uint32_t& threads);
void add_classify_option(CLI::App& command, std::string& processor);
void add_record_option(CLI::App& command, std::string& file);

// Contents of the files that pieces are written to, without the output itself.
void add_export_options(CLI::App& command, ExportSettings& files);
// --export, to `output`, and --export-as, with the options of add_export_options().
void add_state_export(CLI::App& command, std::string& output, ExportSettings& pieces);
// Throws the Failure of --name for a scene.
[[noreturn]] void refuse_name_of_scene();
// Whether the command line gives an option, after parsing. The command must outlive the function.
[[nodiscard]] std::function<bool(const std::string& option)> given_options(const CLI::App& command);
// Returns the settings that have an effect on `files`, which has the output or the stream (piece_export.h), and tells of
// those of a recipe that have none.
[[nodiscard]] ExportSettings settle_export(const CLI::App& command, const ExportSettings& settings,
                                           const ExportSettings& files, const std::string& output_option);
// Refuses a file whose ending names no format that pieces can be written in.
[[nodiscard]] std::string check_export_ending(const std::string& file);
// -o, a file or "-", and --output-format, to `output` and `stream` as in ExportSettings.
void add_output_options(CLI::App& command, std::string& output, std::string& stream, const std::string& help);
// Makes the output "-" a stream, and refuses --output-format for a file. After parsing.
void settle_output(const CLI::App& command, std::string& output, std::string& stream, bool json);

} // namespace brittle::tools
