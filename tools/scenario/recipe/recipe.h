// A recipe: a self-contained JSON file that names a mesh and describes its fracture, its physics and its pictures.
// assets/recipe.schema.json describes the format.
//
//     {"brittle": 1, "mesh": "bunny.obj", "pattern": {"type": "radial", "count": 80, "focus": [0.5, 0.9, 0.5]}}
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "tools/scenario/recipe/input.h"

namespace brittle::tools {

inline constexpr size_t max_recipe_bytes = size_t{1} << 20; // of a file

// Limits on the sites that a recipe lists itself; with them a recipe stays below 1 MiB, the limit of the reader.
inline constexpr uint32_t max_group = 1'000'000; // maximum number of a group of sites
inline constexpr double max_weight = 1e12;       // m^2, maximum weight of a site; its negative is the minimum
inline constexpr size_t max_points = 10'000;

inline constexpr size_t max_objects = 10'000; // of a scene
inline constexpr size_t max_joints = 1000;    // of a recipe
inline constexpr uint32_t max_links = 1000;   // of a joint
inline constexpr size_t max_anchors = 1000;   // maximum number of anchors; every piece is compared with each of them

// Returns the options as the text of a recipe, with paths as they are in the options.
[[nodiscard]] std::string recipe_json(const FractureOptions& options);
// Returns the options as a recipe with paths relative to `folder`, an absolute path. Absolute paths and shapes stay.
[[nodiscard]] nlohmann::ordered_json recipe_object(const FractureOptions& options, const std::filesystem::path& folder);

// Reads a recipe into `options`. Options that the recipe does not mention stay. Relative paths in the recipe count from
// its folder. Throws a Failure with exit_input that names the file, the JSON path of an unknown key or bad value, and
// the expected value.
void read_recipe(const std::filesystem::path& file, FractureOptions& options);
// Reads a recipe that is part of a file, at a JSON path in it such as "/recipe".
void read_recipe(const std::filesystem::path& file, const nlohmann::ordered_json& json, const std::string& path,
                 FractureOptions& options);

// Reads the keys of a scene's object that are no matter of its mesh and place, from a JSON path in a file. Throws as
// above.
void read_object_kind(const std::filesystem::path& file, const nlohmann::ordered_json& json, const std::string& path,
                      SceneObject& object);

// Writes the recipe atomically, with paths relative to its folder. Throws a Failure.
void write_recipe(const std::filesystem::path& file, const FractureOptions& options);

} // namespace brittle::tools
