// Files for tests: a folder of their own, and whole files as text.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <doctest/doctest.h>
#include <unistd.h>

namespace brittle::test_files {

inline std::string read_text(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

inline void write_text(const std::filesystem::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
}

// Where folders of tests are made: in memory, unless TMPDIR is set or there is little of it (containers have 64 MiB). What
// the program exports it writes through to the disk, file by file: hundreds of files take minutes on a busy one.
inline std::filesystem::path place_for_folders() {
    constexpr uintmax_t room = uintmax_t{1} << 30; // bytes
    std::error_code none;
    const bool memory = !std::getenv("TMPDIR") && std::filesystem::space("/dev/shm", none).available >= room && !none
                        && access("/dev/shm", W_OK) == 0;
    return memory ? std::filesystem::path("/dev/shm") : std::filesystem::temp_directory_path();
}

// Of one test case, removed at the end.
class Folder {
  public:
    Folder() {
        std::string pattern = (place_for_folders() / "brittle-test-XXXXXX").string();
        REQUIRE(mkdtemp(pattern.data()) != nullptr);
        path = pattern;
    }
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    [[nodiscard]] std::string operator/(const std::string& name) const { return (path / name).string(); }
    std::filesystem::path write(const std::string& name, const std::string& text) const {
        write_text(path / name, text);
        return path / name;
    }
    [[nodiscard]] size_t files() const {
        return static_cast<size_t>(
            std::distance(std::filesystem::directory_iterator(path), std::filesystem::directory_iterator()));
    }

    std::filesystem::path path;
};

} // namespace brittle::test_files
