// File names of picture sequences, such as `fall_%04d.png`.
#pragma once

#include <cstdint>
#include <string>

namespace brittle::tools {

// True when the pattern holds exactly one `%d`, `%4d` or `%04d` (any width up to 9) and no other `%` but `%%`.
[[nodiscard]] bool is_numbered(const std::string& pattern);
// True when the pattern has no `%` but `%%`.
[[nodiscard]] bool is_plain(const std::string& pattern);

// The file name of a frame; the pattern must be numbered or plain.
[[nodiscard]] std::string picture_name(const std::string& pattern, uint32_t frame);
// The first name of a numbered pattern, up to number 999, that no file has; the last one where all are taken.
[[nodiscard]] std::string unused_name(const std::string& pattern);

} // namespace brittle::tools
