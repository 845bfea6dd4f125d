// The report of a fracture, as text for people and as JSON for programs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/scenario/recipe/export_settings.h"
#include "tools/scenario/recipe/input.h"

namespace brittle::tools {

// Returns a few lines: pieces, certificate, volumes, triangles, milliseconds.
[[nodiscard]] std::string report_text(const Input& input, const Broken& broken);

// Returns an object with the keys mesh, cells, pieces, islands (pieces beyond the first of their cell), closed,
// open_pieces, negative_pieces, volume_input, volume_sum, volume_error, smallest_piece, triangles_in, triangles_out,
// cap_triangles (more with roughness), roughness (0 for flat cuts), crossings (triangles of rough cuts that cross
// their piece), milliseconds {phase: number, ..., total}, hash (16 hexadecimal digits), recipe.
[[nodiscard]] std::string report_json(const Input& input, const Broken& broken, const std::string& recipe);

// Says on standard error that options of one mesh have no effect on a scene, where it has some.
void print_idle_note(const FractureOptions& scene);

// Says on standard error where pieces have files of their own because of the format.
void print_split_note(const ExportSettings& settings, const std::vector<std::filesystem::path>& files);

} // namespace brittle::tools
