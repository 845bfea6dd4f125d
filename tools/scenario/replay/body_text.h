// The text of body checks (BodyChecks) in a replay log: functions to count and compare.
//
// In body order: four hexadecimal digits for a body, or `(3)` for three bodies in a row that did not change in the
// step.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace brittle::tools {

// Returns the number of bodies in a text; nothing if the text is malformed.
[[nodiscard]] std::optional<uint64_t> count_bodies(std::string_view text);

// Returns the index of the first body that differs between two texts of equally many bodies; nothing if they are equal.
[[nodiscard]] std::optional<uint64_t> first_difference(std::string_view a, std::string_view b);

} // namespace brittle::tools
