// A recipe: a JSON file that says which mesh to break and how, whole in itself. assets/recipe.schema.json describes it.
//
//     {"brittle": 1, "mesh": "bunny.obj", "pattern": {"type": "radial", "count": 80, "focus": [0.5, 0.9, 0.5]}}
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "tools/brittle/recipe/input.h"

namespace brittle::tools {

// Sites that a recipe may list itself: all of it stays below the longest file that is read, 1 MiB.
inline constexpr uint32_t max_group = 1'000'000; // number of a group of sites
inline constexpr double max_weight = 1e12;       // m^2, of a site, and its negative the least
inline constexpr size_t max_points = 10'000;

inline constexpr size_t max_anchors = 1000; // that a recipe may have; pieces are compared with each

// The options as a recipe. Paths are as in the options.
[[nodiscard]] std::string recipe_json(const FractureOptions& options);
// The same with paths relative to a folder, which is absolute; absolute paths and shapes stay.
[[nodiscard]] nlohmann::ordered_json recipe_object(const FractureOptions& options, const std::filesystem::path& folder);

// Takes over what the recipe says; what it does not mention stays. Relative paths in it count from its folder. Throws a
// Failure with exit_input that names the file and the JSON path of an unknown key or a bad value, and what was expected.
void read_recipe(const std::filesystem::path& file, FractureOptions& options);
// The same with a recipe that is part of a file, at a JSON path in it such as "/recipe".
void read_recipe(const std::filesystem::path& file, const nlohmann::ordered_json& json, const std::string& path,
                 FractureOptions& options);

// Writes the recipe, with paths relative to its folder. Atomic. Throws a Failure.
void write_recipe(const std::filesystem::path& file, const FractureOptions& options);

} // namespace brittle::tools
