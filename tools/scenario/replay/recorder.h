// Records a replay log of a simulation. The log is kept in memory (about a hundred bytes per step and four per step for
// each moving body) and written at the end, as a whole or not at all.
//
//     Recorder recorder("run.log", options);      // before the pieces exist
//     simulation.observe(&recorder);
//     simulation.start(...), apply(...), advance(...) ...
//     recorder.finish();
//
// A recorder without a file only keeps the log until save():
//
//     Recorder recorder(options);
//     ...
//     recorder.save("run.log");
//
// Without finish(), as after a cancellation or an exception, the destructor writes the log so far and reports that to
// the host. Each start begins a new log, so the file holds the last run.
#pragma once

#include <filesystem>
#include <string>

#include "tools/scenario/replay/body_checks.h"
#include "tools/scenario/replay/log.h"
#include "tools/scenario/run/simulation.h"

namespace brittle::tools {

class Recorder : public SimulationObserver {
  public:
    // `options` is the recipe of the pieces at the next start; the world is taken from the start itself.
    Recorder(std::filesystem::path file, const FractureOptions& options, Host host = {});
    explicit Recorder(const FractureOptions& options) : Recorder({}, options) {} // without a file
    ~Recorder() override;
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    // Sets the recipe for the next start.
    void use_recipe(const FractureOptions& options) { options_ = options; }

    // Writes the log atomically. No effect if no simulation was started or no file was named. Throws a Failure.
    void finish();
    // Writes the log so far atomically; recording goes on. Throws a Failure, with exit_usage if no simulation was
    // started.
    void save(const std::filesystem::path& file) const;

    void started(const Simulation& simulation, std::span<const PreparedObject> objects,
                 const WorldOptions& world) override;
    void acted(uint64_t step, const Action& action) override;
    void stepped(const Simulation& simulation) override;

  private:
    void add_state(const Simulation& simulation);
    // Returns the log so far. Paths in it are relative to the folder of `file`.
    [[nodiscard]] std::string text(const std::filesystem::path& file, const std::string& end) const;

    std::filesystem::path file_;
    FractureOptions options_;
    Host host_;
    BodyChecks checks_;
    ReplayLog header_;
    std::string text_; // all lines after the header; empty: no simulation was started
    uint64_t steps_ = 0;
    bool finished_ = false;
};

} // namespace brittle::tools
