// Replaces a file atomically: a reader sees the old content or the new one, never a part.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "fracture/base/error.h"

namespace brittle::fracture {

// A file that is written, but does not have its name yet. Several files of one export appear together or not at all:
// stage all of them, then commit all. Without a commit the destructor deletes it. As a program that is killed runs no
// destructor, the next one that writes to the folder deletes what dead processes of the same machine left there.
class StagedFile {
  public:
    // Errors and special cases as for write_file_atomically(). A path that is not a regular file is written at once.
    [[nodiscard]] static Result<StagedFile> write(const std::filesystem::path& file, std::span<const std::byte> bytes);
    StagedFile(StagedFile&& other) noexcept;
    StagedFile& operator=(StagedFile&&) = delete;
    ~StagedFile();

    // Gives the file its name, in place of an old one.
    [[nodiscard]] Result<void> commit();

  private:
    StagedFile() = default;

    std::filesystem::path file_, target_, temporary_; // the name asked for; that after links; empty once committed
    bool exists_ = false;                             // whether there was an old file
};

// Writes to a temporary file in the same folder, flushes it to the disk and renames it. On failure (no folder, no
// permission, disk full) the old file stays, the temporary file is removed, and the error (write_failed) names the path
// and the reason that the system gives. The new file inherits the permissions of the old one. A symbolic link is
// followed and stays a link. A path that is not a regular file (a pipe, /dev/stdout) cannot be replaced and is written
// to directly.
[[nodiscard]] Result<void> write_file_atomically(const std::filesystem::path& file, std::span<const std::byte> bytes);

} // namespace brittle::fracture
