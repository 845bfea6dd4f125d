// What the tests of the program share: a folder of their own, and the program run as people run it.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace brittle::tools::test {

inline std::string read_text(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

inline void write_text(const std::filesystem::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
}

// Of one test case, removed at the end.
class Folder {
  public:
    Folder() {
        std::string pattern = (std::filesystem::temp_directory_path() / "brittle-test-XXXXXX").string();
        REQUIRE(mkdtemp(pattern.data()) != nullptr);
        path = pattern;
    }
    ~Folder() { std::filesystem::remove_all(path); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    [[nodiscard]] std::string operator/(const std::string& name) const { return (path / name).string(); }
    [[nodiscard]] std::filesystem::path write(const std::string& name, const std::string& text) const {
        write_text(path / name, text);
        return path / name;
    }
    [[nodiscard]] size_t files() const {
        return static_cast<size_t>(
            std::distance(std::filesystem::directory_iterator(path), std::filesystem::directory_iterator()));
    }

    std::filesystem::path path;
};

struct Outcome {
    int exit_code = -1;
    std::string output; // standard output and standard error

    [[nodiscard]] bool has(const std::string& text) const { return output.find(text) != std::string::npos; }
};

// `environment`: words like NAME=VALUE before the command.
inline Outcome run_brittle(const Folder& folder, const std::string& arguments, const std::string& environment = "") {
    const std::string log = folder / "output";
    const std::string command = environment + " /usr/bin/timeout 120 " BRITTLE_PROGRAM " " + arguments + " >" + log + " 2>&1";
    const int status = std::system(command.c_str());
    Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_text(log)};
    std::filesystem::remove(log);
    return outcome;
}

} // namespace brittle::tools::test
