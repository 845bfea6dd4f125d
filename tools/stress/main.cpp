// Stress test: fractures random difficult meshes and checks every result. See --help.
#include <chrono>
#include <cstdio>
#include <map>
#include <string>

#include <CLI/CLI.hpp>

#include "fracture/io/atomic_file.h"
#include "tools/stress/case.h"
#include "tools/stress/check.h"
#include "tools/stress/isolate.h"
#include "tools/stress/shrink.h"

namespace {

using namespace brittle;

constexpr unsigned max_tries = 600;

struct Options {
    double minutes = 1.0;
    uint64_t cases = 0;
    uint64_t seed = 1;
    std::string family, replay, save = "stress_failures";
    unsigned seconds = 60;
    uint64_t memory_mib = 2048;
    bool quiet = false;
};

std::string check(const Options& options, const stress::Case& c) {
    return stress::isolated([&] { return stress::complaint(c); }, options.seconds, options.memory_mib << 20);
}

void report_failure(const Options& options, const stress::Case& c, const std::string& wrong, uint64_t seed) {
    std::printf("seed %llu (%s): %s\n", static_cast<unsigned long long>(seed), c.family.c_str(), wrong.c_str());
    // The kind of a failure: the letters of its message. Its numbers may change while the case shrinks.
    const auto words = [](const std::string& text) {
        std::string kept;
        for (const char letter : text)
            if ((letter >= 'a' && letter <= 'z') || letter == ' ') kept += letter;
        return kept.substr(0, 24);
    };
    const stress::Case small = stress::shrink(
        c, [&](const stress::Case& candidate) { return words(check(options, candidate)) == words(wrong); }, max_tries);
    const std::filesystem::path file = std::filesystem::path(options.save) / ("seed_" + std::to_string(seed) + ".txt");
    const std::string text = stress::to_text(small);
    std::error_code ignored;
    std::filesystem::create_directories(options.save, ignored);
    if (const auto written = fracture::write_file_atomically(file, std::as_bytes(std::span(text))); !written)
        std::printf("  %s\n", written.error().message.c_str());
    else
        std::printf("  shrunk to %zu triangles and %zu sites (%s): %s\n", small.mesh.triangles.size(),
                    small.sites.size(), check(options, small).c_str(), file.c_str());
    std::fflush(stdout);
}

int replay(const Options& options) {
    const auto c = stress::read_case(options.replay);
    if (!c) return std::printf("%s\n", c.error().message.c_str()), 2;
    const std::string wrong = check(options, *c);
    std::printf("%s: %s\n", c->family.c_str(), wrong.empty() ? "holds" : wrong.c_str());
    return wrong.empty() ? 0 : 1;
}

int run(const Options& options) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    const auto minutes = [&] { return std::chrono::duration<double>(Clock::now() - start).count() / 60.0; };
    uint64_t done = 0, failures = 0;
    std::map<std::string, uint64_t> by_family;
    double next_report = 1.0;
    for (uint64_t seed = options.seed; options.cases > 0 ? done < options.cases : minutes() < options.minutes; ++seed) {
        const stress::Case c = stress::random_case(seed, options.family);
        const std::string wrong = check(options, c);
        ++by_family[c.family.substr(0, c.family.find(','))];
        ++done;
        if (!wrong.empty()) {
            ++failures;
            report_failure(options, c, wrong, seed);
        }
        if (!options.quiet && minutes() > next_report) {
            std::printf("%.0f min: %llu cases, %llu failures, seed %llu\n", minutes(),
                        static_cast<unsigned long long>(done), static_cast<unsigned long long>(failures),
                        static_cast<unsigned long long>(seed));
            std::fflush(stdout);
            next_report += 1.0;
        }
    }
    std::printf("%llu cases in %.1f minutes, %llu failures\n", static_cast<unsigned long long>(done), minutes(),
                static_cast<unsigned long long>(failures));
    for (const auto& [family, count] : by_family)
        std::printf("  %-14s %8llu\n", family.c_str(), static_cast<unsigned long long>(count));
    return failures == 0 ? 0 : 1;
}

} // namespace

int main(int count, char** arguments) {
    Options options;
    CLI::App app("Fractures random difficult meshes (thin, overlapping, broken, degenerate) and checks every result "
                 "by independent oracles. A failure is shrunk and saved as a file for tests/corpus/fractures.");
    app.add_option("--minutes", options.minutes, "duration of the run")->capture_default_str();
    app.add_option("--cases", options.cases, "number of cases, instead of a duration");
    app.add_option("--seed", options.seed, "seed of the first case; later cases count up from it")
        ->capture_default_str();
    app.add_option("--family", options.family, "only meshes of this family")
        ->check(
            CLI::IsMember(std::vector<std::string>(stress::mesh_families().begin(), stress::mesh_families().end())));
    app.add_option("--replay", options.replay, "check a saved case")->check(CLI::ExistingFile);
    app.add_option("--save", options.save, "folder for failing cases")->capture_default_str();
    app.add_option("--seconds", options.seconds, "limit of CPU time for a case")->capture_default_str();
    app.add_option("--memory", options.memory_mib, "limit of memory for a case, MiB")->capture_default_str();
    app.add_flag("--quiet", options.quiet, "print only failures and the total");
    CLI11_PARSE(app, count, arguments);
    return options.replay.empty() ? run(options) : replay(options);
}
