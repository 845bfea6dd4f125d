#include "fracture/io/atomic_file.h"

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace brittle::fracture {
namespace {

namespace fs = std::filesystem;

Error write_error(const fs::path& file, const std::string& doing, int code, const char* advice = "") {
    return {Status::write_failed, file.string() + ": " + doing + ": " + std::strerror(code) + advice};
}

// Writes all bytes, then flushes and closes, even after a failure. Returns 0, or the errno of the first failure.
int write_flush_close(int descriptor, std::span<const std::byte> bytes) {
    int code = 0;
    while (!bytes.empty() && code == 0) {
        const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
        if (written >= 0)
            bytes = bytes.subspan(static_cast<size_t>(written));
        else if (errno != EINTR)
            code = errno;
    }
    // Without the flush, a power cut after the rename can leave an empty file under the final name. Pipes and devices
    // cannot be flushed and give EINVAL.
    if (code == 0 && ::fsync(descriptor) != 0 && errno != EINVAL && errno != EROFS && errno != ENOTSUP) code = errno;
    if (::close(descriptor) != 0 && code == 0 && errno != EINTR) code = errno;
    return code;
}

// A file name that no other call, thread or process uses. Short and independent of the target's name, which may already
// have the maximum length of the file system.
fs::path temporary_name(const fs::path& folder) {
    static std::atomic<uint32_t> counter = 0;
    return folder / (".brittle-" + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp");
}

Result<void> write_directly(const fs::path& file, std::span<const std::byte> bytes) {
    const int descriptor = ::open(file.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor < 0) return write_error(file, "cannot open it for writing", errno);
    if (const int code = write_flush_close(descriptor, bytes)) return write_error(file, "cannot write", code);
    return {};
}

} // namespace

Result<void> write_file_atomically(const fs::path& file, std::span<const std::byte> bytes) {
    if (file.empty()) return Error{Status::write_failed, "cannot write to an empty file name; give one"};

    struct stat old {};
    const bool exists = ::stat(file.c_str(), &old) == 0;
    if (exists && S_ISDIR(old.st_mode)) {
        return write_error(file, "cannot write", EISDIR, "; give the name of a file in it");
    }
    if (exists && !S_ISREG(old.st_mode)) return write_directly(file, bytes);

    fs::path target = file;
    std::error_code no_link;
    if (exists && fs::is_symlink(file, no_link)) {
        const fs::path resolved = fs::canonical(file, no_link);
        if (!no_link) target = resolved;
    }
    const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");

    const fs::path temporary = temporary_name(folder);
    const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0) {
        const int code = errno;
        return write_error(file, "cannot create a file in " + folder.string(), code,
                           code == ENOENT ? "; make the folder first" : "");
    }
    if (exists) {
        // Best effort: the call fails where the owner differs, and the content matters more.
        [[maybe_unused]] const int ignored = ::fchmod(descriptor, old.st_mode & 07777);
    }
    int code = write_flush_close(descriptor, bytes);
    if (code == 0 && ::rename(temporary.c_str(), target.c_str()) != 0) code = errno;
    if (code != 0) {
        ::unlink(temporary.c_str());
        return write_error(file, "cannot write", code, exists ? "; the old file is unchanged" : "");
    }

    // Makes the rename itself durable. A file system without support for it gives no error, since the content is safe.
    if (const int handle = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); handle >= 0) {
        [[maybe_unused]] const int ignored = ::fsync(handle);
        ::close(handle);
    }
    return {};
}

} // namespace brittle::fracture
