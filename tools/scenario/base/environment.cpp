#include "tools/scenario/base/environment.h"

#include <fstream>
#include <string>
#include <thread>

#include <sys/utsname.h>

#include "brittle_commit.h"

namespace brittle::tools {

namespace {

std::string processor_name() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);) {
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    }
    return "unknown";
}

std::string system_name() {
    utsname names{};
    if (uname(&names) != 0) return "unknown";
    const std::string release = names.release; // everything after the version numbers names the builder
    return std::string(names.sysname) + " " + release.substr(0, release.find('-')) + " " + names.machine;
}

std::string compiler_name() {
#if defined(__clang__)
    return "clang " + std::to_string(__clang_major__) + "." + std::to_string(__clang_minor__) + "."
           + std::to_string(__clang_patchlevel__);
#elif defined(__GNUC__)
    return "gcc " + std::to_string(__GNUC__) + "." + std::to_string(__GNUC_MINOR__) + "."
           + std::to_string(__GNUC_PATCHLEVEL__);
#else
    return "unknown";
#endif
}

} // namespace

nlohmann::ordered_json environment() {
    return {{"brittle", BRITTLE_VERSION},
            {"commit", BRITTLE_COMMIT},
            {"compiler", compiler_name()},
            {"build", BRITTLE_BUILD},
            {"system", system_name()},
            {"processor", processor_name()},
            {"hardware_threads", std::thread::hardware_concurrency()}};
}

} // namespace brittle::tools
