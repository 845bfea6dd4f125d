// A replay log: what a simulation began with, what was done to it and when, and a hash of its state after
// each step. docs/replay.md and assets/replay.schema.json describe the file, a line of JSON for each of
// these.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "physics/cutting/destruction.h"
#include "tools/brittle/recipe/input.h"
#include "tools/brittle/run/action.h"

namespace brittle::tools {

struct ReplayLog {
    nlohmann::ordered_json build; // environment() of who recorded it
    double step_seconds = 0.0;
    size_t pieces = 0;
    uint64_t pieces_hash = 0; // fracture::hash()
    FractureOptions recipe;   // without shots: they are actions
    struct State {
        uint64_t hash = 0;  // Simulation::state_hash()
        std::string bodies; // BodyChecks
    };
    std::vector<State> states{};                        // [k]: after k steps; [0] before any action
    std::vector<std::pair<uint64_t, Action>> actions{}; // with the steps they take effect after, ascending
    std::vector<physics::Commit> commits{};             // of cuts, ascending by the step that they are part of
    std::string end{};                                  // "finished", or why it was cut short: "interrupted", "failed"
};

// Throws a Failure with exit_input that names line and field.
[[nodiscard]] ReplayLog read_replay_log(const std::filesystem::path& file);

// Lines of the file, each with its end.
[[nodiscard]] std::string header_line(const ReplayLog& log, const std::filesystem::path& folder);
[[nodiscard]] std::string state_line(uint64_t step, const ReplayLog::State& state);
[[nodiscard]] std::string action_line(uint64_t step, const Action& action);
// Goes before the state of its step.
[[nodiscard]] std::string commit_line(const physics::Commit& commit);
[[nodiscard]] std::string end_line(uint64_t steps, const std::string& end);

// Sixteen hexadecimal digits.
[[nodiscard]] std::string hash_text(uint64_t hash);

} // namespace brittle::tools
