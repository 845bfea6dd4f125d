// Repeats what a replay log tells and compares the state after each step.
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
// It may as well be driven by Simulation::advance(), at any frame rate; steps beyond the log's are not
// compared.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tools/brittle/replay/body_checks.h"
#include "tools/brittle/replay/log.h"
#include "tools/brittle/run/simulation.h"

namespace brittle::tools {

struct Difference {
    uint64_t step;    // the first that differs; 0 is the state before the first step
    std::string what; // for people
};

class Player : public SimulationObserver {
  public:
    explicit Player(const ReplayLog& log); // which must outlive it

    [[nodiscard]] bool done() const { return compared_ >= log_.states.size(); }
    [[nodiscard]] const std::optional<Difference>& difference() const { return difference_; }

    void started(const Simulation& simulation, const fracture::Fragments& fragments,
                 const WorldOptions& world) override;
    void stepped(const Simulation& simulation) override;

  private:
    void compare(const Simulation& simulation);

    const ReplayLog& log_;
    BodyChecks checks_;
    uint64_t compared_ = 0; // states
    std::optional<Difference> difference_;
};

// Before the start: what is cut anew comes as the log says.
void follow(const ReplayLog& log, Simulation& simulation);
// After it: the log's actions, each at its step.
void schedule(const ReplayLog& log, Simulation& simulation);

// What differs between the build that recorded and this one, for people; empty where nothing that matters
// does.
[[nodiscard]] std::string other_build(const ReplayLog& log);

} // namespace brittle::tools
