// Actions as JSON: an object of one key, the action's name, with its fields: {"push": {"piece": 4, ...}}.
// assets/replay.schema.json describes them.
#pragma once

#include <filesystem>
#include <optional>

#include <nlohmann/json.hpp>

#include "tools/brittle/recipe/json_reader.h"
#include "tools/brittle/run/action.h"

namespace brittle::tools {

// Adds the action to an object.
void write_action(nlohmann::ordered_json& object, const Action& action);

// The action among an object's keys, or nothing. `where` is the file for messages; all fields are required.
// Throws a Failure that names the field, also for what fault_of() finds.
[[nodiscard]] std::optional<Action> read_action(const std::filesystem::path& where, JsonReader& reader,
                                                size_t piece_count);

} // namespace brittle::tools
