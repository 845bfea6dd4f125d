// Parts of a recipe as JSON: the keys of a world, those of one object in it, the contents of pictures and of files of
// pieces. Reading refuses values out of range; the caller refuses unknown keys.
#pragma once

#include <filesystem>
#include <string>

#include <glm/vec3.hpp>
#include <nlohmann/json_fwd.hpp>

#include "tools/scenario/recipe/export_settings.h"
#include "tools/scenario/recipe/json_reader.h"
#include "tools/scenario/recipe/picture_options.h"
#include "tools/scenario/recipe/world_options.h"

namespace brittle::tools {

[[nodiscard]] nlohmann::ordered_json vector_json(const glm::dvec3& v);

// Adds the values that differ from the defaults: how an object holds together and breaks.
void add_body(const WorldOptions& world, nlohmann::ordered_json& json);
// Adds those of the world around it: the engine, the air, limits, shots and joints.
void add_world(const WorldOptions& world, nlohmann::ordered_json& json);
[[nodiscard]] nlohmann::ordered_json picture_json(const PictureOptions& picture);
[[nodiscard]] nlohmann::ordered_json export_json(const ExportSettings& settings);

// Read what the functions above write. `path` is the reader's.
void read_body(const std::filesystem::path& file, const std::string& path, JsonReader& reader, WorldOptions& world);
void read_world(const std::filesystem::path& file, const std::string& path, JsonReader& reader, WorldOptions& world);
void read_picture(JsonReader& reader, PictureOptions& picture);
void read_export(JsonReader& reader, ExportSettings& settings);

} // namespace brittle::tools
