// The text by which a replay log tells the bodies after a step (BodyChecks), to be counted and compared.
//
// In body order: four hexadecimal digits for a body, `(3)` for three bodies in a row that are as
// they were after the step before.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace brittle::tools {

// How many bodies a text is about; nothing if it is no such text.
[[nodiscard]] std::optional<uint64_t> count_bodies(std::string_view text);

// The first body, in order, for which the texts differ, both of as many bodies. Nothing where they agree.
[[nodiscard]] std::optional<uint64_t> first_difference(std::string_view a, std::string_view b);

} // namespace brittle::tools
