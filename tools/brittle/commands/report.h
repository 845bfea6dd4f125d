// The report of a fracture, as text for people and as JSON for programs.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tools/scenario/recipe/export_settings.h"
#include "tools/scenario/recipe/input.h"
#include "tools/scenario/run/broken_scene.h"

namespace brittle::tools {

// Returns a few lines: pieces, certificate, volumes, triangles, milliseconds.
[[nodiscard]] std::string report_text(const Input& input, const Broken& broken);

// Returns an object with the keys mesh, cells, pieces, islands (pieces beyond the first of their cell), closed,
// open_pieces, negative_pieces, volume_input, volume_sum, volume_error, smallest_piece, triangles_in, triangles_out,
// cap_triangles (more with roughness), roughness (0 for flat cuts), crossings (triangles of rough cuts that cross
// their piece), milliseconds {phase: number, ..., total}, hash (16 hexadecimal digits), recipe.
[[nodiscard]] std::string report_json(const Input& input, const Broken& broken, const std::string& recipe);

// What the certificates of the objects of a scene say together.
struct SceneCertificate {
    size_t objects = 0;            // that are not fixed
    size_t pieces = 0;             // of these
    size_t open_pieces = 0;        // of these
    double volume_input = 0.0;     // m^3
    double volume_sum = 0.0;       // m^3
    double max_volume_error = 0.0; // of one object
};
[[nodiscard]] SceneCertificate certify(std::span<const BrokenObject> objects);

// The same texts for a scene. The JSON has the keys objects (for each: name, fixed, sites, milliseconds, and unless it is
// fixed the keys of its certificate), pieces, open_pieces, closed, max_volume_error, milliseconds, recipe.
[[nodiscard]] std::string report_text(const LoadedScene& scene, std::span<const BrokenObject> objects);
[[nodiscard]] std::string report_json(const LoadedScene& scene, std::span<const BrokenObject> objects,
                                      const std::string& recipe);

// Says on standard error that options of one mesh have no effect on a scene, where it has some.
void print_idle_note(const FractureOptions& scene);

// Says on standard error where pieces have files of their own because of the format.
void print_split_note(const ExportSettings& settings, const std::vector<std::filesystem::path>& files);

} // namespace brittle::tools
