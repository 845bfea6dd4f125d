#include "fracture/io/atomic_file.h"

#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <set>
#include <string>
#include <utility>

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

// The start of the names of temporary files: that of the machine with its process names, then that of the process.
std::string machine_name() {
    char host[256] = "";
    ::gethostname(host, sizeof host - 1);
    struct stat processes {};
    ::stat("/proc/self/ns/pid", &processes); // differs between containers
    uint64_t hash = 0xcbf29ce484222325ull ^ static_cast<uint64_t>(processes.st_ino);
    for (const char* c = host; *c != 0; ++c) hash = (hash ^ static_cast<unsigned char>(*c)) * 0x100000001b3ull;
    return ".brittle-" + std::to_string(hash % 1'000'000'000u) + "-";
}

// A file name that no other call, thread or process uses. Short and independent of the target's name, which may already
// have the maximum length of the file system.
fs::path temporary_name(const fs::path& folder) {
    static std::atomic<uint32_t> counter = 0;
    return folder / (machine_name() + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp");
}

// Deletes temporary files that killed processes of this machine have left in the folder, once for each folder.
void clear_leftovers(const fs::path& folder) {
    static std::mutex clearing;
    static std::set<fs::path> cleared;
    const std::lock_guard lock(clearing);
    if (!cleared.insert(fs::weakly_canonical(folder)).second) return;
    const std::string start = machine_name();
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        const std::string name = at->path().filename().string();
        if (!name.starts_with(start) || !name.ends_with(".tmp")) continue;
        int process = 0;
        const char* const number = name.data() + start.size();
        const auto [stop, code] = std::from_chars(number, name.data() + name.size(), process);
        if (code != std::errc() || *stop != '-' || process <= 0) continue;
        if (::kill(process, 0) != 0 && errno == ESRCH) ::unlink(at->path().c_str());
    }
}

fs::path folder_of(const fs::path& file) {
    return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

Result<void> write_directly(const fs::path& file, std::span<const std::byte> bytes) {
    const int descriptor = ::open(file.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor < 0) return write_error(file, "cannot open it for writing", errno);
    if (const int code = write_flush_close(descriptor, bytes)) return write_error(file, "cannot write", code);
    return {};
}

} // namespace

Result<StagedFile> StagedFile::write(const fs::path& file, std::span<const std::byte> bytes) {
    if (file.empty()) return Error{Status::write_failed, "cannot write to an empty file name; give one"};

    StagedFile staged;
    staged.file_ = staged.target_ = file;
    struct stat old {};
    staged.exists_ = ::stat(file.c_str(), &old) == 0;
    if (staged.exists_ && S_ISDIR(old.st_mode))
        return write_error(file, "cannot write", EISDIR, "; give the name of a file in it");
    if (staged.exists_ && !S_ISREG(old.st_mode)) {
        if (Result<void> done = write_directly(file, bytes); !done) return done.error();
        return staged;
    }

    std::error_code no_link;
    if (staged.exists_ && fs::is_symlink(file, no_link)) {
        const fs::path resolved = fs::canonical(file, no_link);
        if (!no_link) staged.target_ = resolved;
    }
    const fs::path folder = folder_of(staged.target_);
    clear_leftovers(folder);
    const fs::path temporary = temporary_name(folder);
    const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0) {
        const int code = errno;
        return write_error(file, "cannot create a file in " + folder.string(), code,
                           code == ENOENT ? "; make the folder first" : "");
    }
    staged.temporary_ = temporary;
    if (staged.exists_) {
        // Best effort: the call fails where the owner differs, and the content matters more.
        [[maybe_unused]] const int ignored = ::fchmod(descriptor, old.st_mode & 07777);
    }
    if (const int code = write_flush_close(descriptor, bytes))
        return write_error(file, "cannot write", code, staged.exists_ ? "; the old file is unchanged" : "");
    return staged;
}

Result<void> StagedFile::commit() {
    if (temporary_.empty()) return {};
    if (::rename(temporary_.c_str(), target_.c_str()) != 0)
        return write_error(file_, "cannot write", errno, exists_ ? "; the old file is unchanged" : "");
    temporary_.clear();
    // Makes the rename itself durable. A file system without support for it gives no error, since the content is safe.
    if (const int handle = ::open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); handle >= 0) {
        [[maybe_unused]] const int ignored = ::fsync(handle);
        ::close(handle);
    }
    return {};
}

StagedFile::StagedFile(StagedFile&& other) noexcept
    : file_(std::move(other.file_)), target_(std::move(other.target_)),
      temporary_(std::exchange(other.temporary_, fs::path())), exists_(other.exists_) {}

StagedFile::~StagedFile() {
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

Result<void> write_file_atomically(const fs::path& file, std::span<const std::byte> bytes) {
    Result<StagedFile> staged = StagedFile::write(file, bytes);
    if (!staged) return staged.error();
    return staged->commit();
}

} // namespace brittle::fracture
