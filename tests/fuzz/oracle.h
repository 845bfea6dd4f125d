// The promises of every reader for arbitrary bytes, besides not to crash. A broken promise ends the program, which the
// fuzzer reports as a finding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <string>

#include <sys/mman.h>
#include <unistd.h>

namespace brittle::fuzz {

// The maximum processor time per file, in seconds, under sanitizers too. Processor time, because the machine may be
// busy.
constexpr double max_seconds = 2.0;
// The maximum length of a message in bytes: a person reads it.
constexpr size_t max_message_length = 2000;

inline void require(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "ORACLE: %s\n", what);
    std::abort();
}

// Checks that an error has a message without terminal control characters. A command's may have several lines.
inline void check_message(const std::string& message, bool of_lines = false) {
    require(!message.empty(), "an error without a message");
    require(message.size() <= max_message_length, "an endless message");
    for (const char c : message)
        require(static_cast<unsigned char>(c) >= 0x20 || (of_lines && c == '\n'), "a control character in a message");
}

class TimeGuard {
  public:
    explicit TimeGuard(double seconds = max_seconds) : seconds_(seconds) {}
    TimeGuard(const TimeGuard&) = delete;
    TimeGuard& operator=(const TimeGuard&) = delete;
    ~TimeGuard() {
        const double seconds = static_cast<double>(std::clock() - begin_) / CLOCKS_PER_SEC;
        require(seconds < seconds_, "it takes too long");
    }

  private:
    double seconds_;
    std::clock_t begin_ = std::clock();
};

// A file in memory with these bytes, for readers that take a path.
class MemoryFile {
  public:
    MemoryFile(const uint8_t* data, size_t size) : descriptor_(::memfd_create("input", 0)) {
        require(descriptor_ >= 0 && ::write(descriptor_, data, size) == static_cast<ssize_t>(size), "no memory file");
        path_ = "/proc/self/fd/" + std::to_string(descriptor_);
    }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    ~MemoryFile() { ::close(descriptor_); }

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  private:
    int descriptor_;
    std::filesystem::path path_;
};

} // namespace brittle::fuzz
