// Comparison of two profiles, to find times that became slower.
//
// Scenarios correspond by name. A phase is `slower` if both its median and its minimum exceed `threshold` times the old
// values: slower code is slower every time, while other load on the machine spares the best sample. If only the median
// exceeds it, the phase is `noise`. `faster` is the converse. Fewer than five samples on either side allow no verdict
// (`few`). Only the total of the fracture and the frames before and after it decide; the other phases show the cause.
// Compare runs on one idle machine.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace brittle::tools {

enum class Verdict { same, faster, slower, noise, few };

[[nodiscard]] const char* to_string(Verdict verdict);

struct ComparedPhase {
    std::string scenario;
    std::string group; // "fracture", "frames whole", ...
    std::string phase;
    double before = 0.0; // medians, ms
    double after = 0.0;
    double ratio = 1.0; // after / before; infinite if only `before` is zero
    Verdict verdict = Verdict::same;
    bool decides = false;
};

struct Comparison {
    double threshold = 1.0;
    std::vector<ComparedPhase> phases;
    std::vector<std::string> notes; // differences that make the comparison doubtful, for people
    bool slower = false;            // whether a phase that decides is slower
};

// Reads an earlier profile. Throws a Failure with exit_input that says what is wrong with the file.
[[nodiscard]] nlohmann::ordered_json read_profile(const std::filesystem::path& file);

// Compares two profiles in the form of read_profile(). Throws a Failure with exit_input if they have no scenario in
// common.
[[nodiscard]] Comparison compare_profiles(const nlohmann::ordered_json& before, const nlohmann::ordered_json& after,
                                          double threshold);

void print_comparison(const Comparison& comparison);

// {threshold, slower, notes, phases [{scenario, group, phase, before, after, ratio, verdict, decides}]}
[[nodiscard]] nlohmann::ordered_json comparison_json(const Comparison& comparison);

} // namespace brittle::tools
