// Recorded and replayed runs, for tests of replay logs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "tools/brittle/stage/stage.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/replay/log.h"
#include "tools/scenario/replay/player.h"
#include "tools/scenario/replay/recorder.h"
#include "tools/scenario/run/scene.h"
#include "tools/scenario/run/simulation.h"

namespace brittle::tools::test {

// Returns the log of a run of `steps` whole steps.
inline ReplayLog recorded(const FractureOptions& options, const fracture::Fragments& fragments, uint64_t steps,
                          const std::vector<std::pair<uint64_t, Action>>& actions, const std::filesystem::path& file) {
    Simulation simulation(options.material);
    Recorder recorder(file, options);
    simulation.observe(&recorder);
    simulation.start(fragments, world_of(options));
    for (const auto& [step, action] : actions) simulation.schedule(step, action);
    while (simulation.steps() < steps) simulation.step();
    recorder.finish();
    return read_replay_log(file);
}

// Replays a log with its actions and the steps of its cuts. Returns the first difference.
inline std::optional<Difference> replayed(const ReplayLog& log, const fracture::Fragments& fragments) {
    Simulation simulation(log.recipe.material);
    Player player(log);
    simulation.observe(&player);
    follow(log, simulation);
    simulation.start(fragments, world_of(log.recipe));
    if (!player.difference()) schedule(log, simulation);
    while (!player.done() && !player.difference()) simulation.step();
    return player.difference();
}

// The same for the log of a scene, prepared and run by a number of threads. `steps` receives those that were taken.
inline std::optional<Difference> replayed_scene(const ReplayLog& log, uint32_t threads, uint64_t& steps) {
    FractureOptions recipe = log.recipe;
    recipe.threads = threads;
    LoadedScene scene = load_scene(recipe);
    Simulation simulation;
    Player player(log);
    simulation.observe(&player);
    follow(log, simulation);
    simulation.start(prepare_scene(scene), scene.world);
    schedule(log, simulation);
    while (!player.done() && !player.difference()) simulation.step();
    steps = simulation.steps();
    return player.difference();
}

// Returns the message of reading a file, or "" if it can be read.
inline std::string message_of(const std::filesystem::path& file) {
    try {
        (void)read_replay_log(file);
    } catch (const Failure& failure) {
        CHECK(failure.code() == exit_input);
        return failure.what();
    }
    return "";
}

} // namespace brittle::tools::test
