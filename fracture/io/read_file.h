// Reads a whole file into memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "fracture/base/error.h"

namespace brittle::fracture {

// Files of this size or more are refused. No mesh that can be fractured is that large, and a wrong name should not fill
// the memory.
inline constexpr uint64_t max_file_size = uint64_t{4} << 30; // bytes

// Errors: file_not_found for a path that is missing, unreadable, a folder, or not a regular file (reading a pipe would
// block for ever); malformed_file for an empty file or one that is too large.
[[nodiscard]] Result<std::vector<std::byte>> read_file(const std::filesystem::path& file);

} // namespace brittle::fracture
