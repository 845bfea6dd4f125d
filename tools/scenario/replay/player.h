// Repeats the run of a replay log and compares the state after each step.
//
//     ReplayLog log = read_replay_log("run.log");
//     Player player(log);
//     simulation.observe(&player);
//     follow(log, simulation);
//     simulation.start(fragments, world_of(log.recipe));
//     schedule(log, simulation);
//     while (!player.done()) simulation.step();
//     if (player.difference()) ...
//
// Simulation::advance() may drive the simulation instead, at any frame rate. Steps beyond the end of the log are not
// compared.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tools/scenario/replay/body_checks.h"
#include "tools/scenario/replay/log.h"
#include "tools/scenario/run/simulation.h"

namespace brittle::tools {

struct Difference {
    uint64_t step;    // first step whose state differs; 0: the state before the first step
    std::string what; // for people
};

class Player : public SimulationObserver {
  public:
    explicit Player(const ReplayLog& log); // `log` must outlive the player

    [[nodiscard]] bool done() const { return compared_ >= log_.states.size(); }
    [[nodiscard]] const std::optional<Difference>& difference() const { return difference_; }

    void started(const Simulation& simulation, std::span<const PreparedObject> objects,
                 const WorldOptions& world) override;
    void stepped(const Simulation& simulation) override;

  private:
    void compare(const Simulation& simulation);

    const ReplayLog& log_;
    BodyChecks checks_;
    uint64_t compared_ = 0; // states
    std::optional<Difference> difference_;
};

// Makes the simulation commit cuts at the steps of the log. Call before the start.
void follow(const ReplayLog& log, Simulation& simulation);
// Schedules the actions of the log at their steps. Call after the start.
void schedule(const ReplayLog& log, Simulation& simulation);

// Returns the differences between the recording build and this one, for people; empty if none of them can change a
// state.
[[nodiscard]] std::string other_build(const ReplayLog& log);

} // namespace brittle::tools
