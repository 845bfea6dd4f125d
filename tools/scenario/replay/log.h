// A replay log: the initial state of a simulation, all actions on it with their steps, and a hash of the state after
// each step. The file has one line of JSON for each of these; docs/replay.md and assets/replay.schema.json describe it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "physics/cutting/destruction.h"
#include "tools/scenario/recipe/input.h"
#include "tools/scenario/run/action.h"

namespace brittle::tools {

struct ReplayLog {
    nlohmann::ordered_json build; // environment() of the recording program
    double step_seconds = 0.0;
    size_t pieces = 0;
    uint64_t pieces_hash = 0; // fracture::hash()
    FractureOptions recipe;   // without shots, which are recorded as actions
    struct State {
        uint64_t hash = 0;  // Simulation::state_hash()
        std::string bodies; // BodyChecks
    };
    std::vector<State> states{};                        // [k]: after k steps; [0] before any action
    std::vector<std::pair<uint64_t, Action>> actions{}; // with the steps after which they take effect, ascending
    std::vector<physics::Commit> commits{};             // commits of cuts, ascending by their step
    std::string end{}; // "finished", or the reason of an early end: "interrupted" or "failed"
};

// Reads a log. Throws a Failure with exit_input that names line and field.
[[nodiscard]] ReplayLog read_replay_log(const std::filesystem::path& file);

// Lines of the file, each with its line end. Paths in the header are relative to `folder`.
[[nodiscard]] std::string header_line(const ReplayLog& log, const std::filesystem::path& folder);
[[nodiscard]] std::string state_line(uint64_t step, const ReplayLog::State& state);
[[nodiscard]] std::string action_line(uint64_t step, const Action& action);
// Precedes the state of its step.
[[nodiscard]] std::string commit_line(const physics::Commit& commit);
[[nodiscard]] std::string end_line(uint64_t steps, const std::string& end);

// Sixteen hexadecimal digits.
[[nodiscard]] std::string hash_text(uint64_t hash);

} // namespace brittle::tools
