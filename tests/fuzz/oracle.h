// What every reader promises about any bytes, beyond that it does not crash. A broken promise ends the
// program, which makes it a finding of the fuzzer.
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

// Processor time, because the machine may be busy. Under sanitizers, at most so many seconds a file.
constexpr double longest_reading = 2.0;
// Bytes; a message is read by a person.
constexpr size_t longest_message = 2000;

inline void require(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "ORACLE: %s\n", what);
    std::abort();
}

// Says what is wrong, and nothing that a terminal would obey.
inline void check_message(const std::string& message) {
    require(!message.empty(), "an error without a message");
    require(message.size() <= longest_message, "an endless message");
    for (const char c : message) require(static_cast<unsigned char>(c) >= 0x20, "a control character in a message");
}

class TimeGuard {
  public:
    TimeGuard() = default;
    TimeGuard(const TimeGuard&) = delete;
    TimeGuard& operator=(const TimeGuard&) = delete;
    ~TimeGuard() {
        const double seconds = static_cast<double>(std::clock() - begin_) / CLOCKS_PER_SEC;
        require(seconds < longest_reading, "reading takes too long");
    }

  private:
    std::clock_t begin_ = std::clock();
};

// A file in memory with the bytes, for readers that take a path.
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
