// A whole file into memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "fracture/base/error.h"

namespace brittle::fracture {

// Files from here on are refused: nothing that can be fractured is that large, and a mistaken name should not
// fill the memory.
inline constexpr uint64_t largest_file = uint64_t{4} << 30; // bytes

// Errors: file_not_found for what is missing, unreadable, a folder, or no regular file (a pipe would block
// for ever); malformed_file for an empty or too large one.
[[nodiscard]] Result<std::vector<std::byte>> read_file(const std::filesystem::path& file);

} // namespace brittle::fracture
