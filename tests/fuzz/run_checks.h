// What the fuzz targets of recipes and logs run, without a renderer, and what must hold of it.
#pragma once

#include <cstdint>
#include <functional>

#include "tools/scenario/recipe/input.h"
#include "tools/scenario/run/simulation.h"

namespace brittle::fuzz {

constexpr uint64_t max_steps = 24;       // of a run
constexpr double max_run_seconds = 60.0; // processor time of a run, under sanitizers

// Bounds counts and lengths, so that a run takes about a second. Names of files become those of tests/corpus/meshes and
// assets/sites, or of files that are not there. Returns false for a shape that takes too long.
[[nodiscard]] bool bound(tools::FractureOptions& options);

// Calls `run`, which may fail as a command may: with a message for people and the exit code of a wrong input. Returns
// whether it did not.
bool run_or_fail(const std::function<void()>& run);

// Loads and breaks what the options name, starts the run, calls `started`, and takes the steps. Checks that pieces are
// closed and have the volume of their mesh, and that all bodies have finite places and speeds after each step. Throws a
// tools::Failure.
void run(const tools::FractureOptions& options, tools::Simulation& simulation, uint64_t steps,
         const std::function<void()>& started = {});

} // namespace brittle::fuzz
