// Writes a file so that a reader sees the old content or the new one, never a part.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "fracture/base/error.h"

namespace brittle::fracture {

// Writes to a temporary name in the same folder, flushes to the disk, renames. On failure (no folder, no
// permission, disk full) the old file stays, the temporary one is removed, and the error (write_failed) names
// the path and the system's reason. The new file takes over the permissions of the old one; a symbolic link
// is followed and stays a link. What is no regular file, like a pipe or /dev/stdout, cannot be replaced and
// is written to directly.
[[nodiscard]] Result<void> write_file_atomically(const std::filesystem::path& file, std::span<const std::byte> bytes);

} // namespace brittle::fracture
