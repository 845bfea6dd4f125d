// Two profiles side by side: did something become slower?
//
// Scenarios are the same where their names are. A phase is `slower` where both its median and its minimum are more than
// `threshold` times the old ones: slower code is slower every time, while other work on the machine spares the luckiest
// sample. Where the median alone is, it is `noise`. `faster` is the other way round. Fewer than five samples on either
// side tell nothing (`few`). Only the fracture's total and the frames before and after it decide; the phases say where
// it comes from. Still, compare runs of one machine that has nothing else to do.
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
    double ratio = 1.0; // after / before; infinite where only `before` is zero
    Verdict verdict = Verdict::same;
    bool decides = false;
};

struct Comparison {
    double threshold = 1.0;
    std::vector<ComparedPhase> phases;
    std::vector<std::string> notes; // what makes the two hard to compare, for people
    bool slower = false;            // a phase that decides is
};

// A profile that was written before. Throws a Failure with exit_input that says what is wrong with the file.
[[nodiscard]] nlohmann::ordered_json read_profile(const std::filesystem::path& file);

// Both as read_profile() gives them. Throws a Failure with exit_input where they have no scenario in common.
[[nodiscard]] Comparison compare_profiles(const nlohmann::ordered_json& before, const nlohmann::ordered_json& after,
                                          double threshold);

void print_comparison(const Comparison& comparison);

// {threshold, slower, notes, phases [{scenario, group, phase, before, after, ratio, verdict, decides}]}
[[nodiscard]] nlohmann::ordered_json comparison_json(const Comparison& comparison);

} // namespace brittle::tools
