// Helpers for tests that run the program as its users do.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>
#include <sys/wait.h>

#include "tests/folder.h"

namespace brittle::tools::test {

using brittle::test_files::Folder;
using brittle::test_files::read_text;
using brittle::test_files::write_text;

struct Outcome {
    int exit_code = -1;
    std::string output; // standard output and standard error

    [[nodiscard]] bool has(const std::string& text) const { return output.find(text) != std::string::npos; }
};

// `environment`: words of the form NAME=VALUE, put before the command.
inline Outcome run_brittle(const Folder& folder, const std::string& arguments, const std::string& environment = "") {
    const std::string log = folder / "output";
    const std::string command =
        environment + " /usr/bin/timeout 120 " BRITTLE_PROGRAM " " + arguments + " >" + log + " 2>&1";
    const int status = std::system(command.c_str());
    Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_text(log)};
    std::filesystem::remove(log);
    return outcome;
}

// Whether a command that draws found no Vulkan device; the test is then skipped, with a message.
inline bool no_vulkan(const Outcome& outcome) {
    if (outcome.exit_code != 6) return false;
    MESSAGE("skipped: no Vulkan device");
    return true;
}

} // namespace brittle::tools::test
