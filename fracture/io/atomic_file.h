// Replaces a file atomically: a reader sees the old content or the new one, never a part.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "fracture/base/error.h"

namespace brittle::fracture {

// Writes to a temporary file in the same folder, flushes it to the disk and renames it. On failure (no folder, no
// permission, disk full) the old file stays, the temporary file is removed, and the error (write_failed) names the path
// and the reason that the system gives. The new file inherits the permissions of the old one. A symbolic link is
// followed and stays a link. A path that is not a regular file (a pipe, /dev/stdout) cannot be replaced and is written
// to directly.
[[nodiscard]] Result<void> write_file_atomically(const std::filesystem::path& file, std::span<const std::byte> bytes);

} // namespace brittle::fracture
