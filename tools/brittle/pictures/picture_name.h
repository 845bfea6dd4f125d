// File names of sequences of pictures, e.g. `fall_%04d.png`.
#pragma once

#include <cstdint>
#include <string>

namespace brittle::tools {

// Returns whether the pattern holds exactly one `%d`, `%4d` or `%04d` (with any width up to 9) and no other `%` but
// `%%`.
[[nodiscard]] bool is_numbered(const std::string& pattern);
// Returns whether the pattern has no `%` but `%%`.
[[nodiscard]] bool is_plain(const std::string& pattern);

// Returns the file name of a frame. The pattern must be numbered or plain.
[[nodiscard]] std::string picture_name(const std::string& pattern, uint32_t frame);
// Returns the first name of a numbered pattern, with numbers up to 999, that no file has; the last one if all are
// taken.
[[nodiscard]] std::string unused_name(const std::string& pattern);

} // namespace brittle::tools
