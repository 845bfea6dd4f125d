// JSON of actions: an object with one key, the name of the action, whose value holds the fields: {"push": {"piece": 4,
// ...}}. assets/replay.schema.json describes them.
#pragma once

#include <filesystem>
#include <optional>

#include <nlohmann/json.hpp>

#include "tools/scenario/recipe/json_reader.h"
#include "tools/scenario/run/action.h"

namespace brittle::tools {

// Adds the action to an object.
void write_action(nlohmann::ordered_json& object, const Action& action);

// Returns the action among the keys of an object, or nothing. `where` is the file for messages. All fields are
// required. Throws a Failure that names the field if a field is invalid by type or by fault_of().
[[nodiscard]] std::optional<Action> read_action(const std::filesystem::path& where, JsonReader& reader,
                                                size_t piece_count);

} // namespace brittle::tools
