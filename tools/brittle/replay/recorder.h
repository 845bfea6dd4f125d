// Writes a replay log of a simulation. The log is kept in memory and written at the end, whole or not at all:
// about a hundred bytes a step and four for each body that moves in it.
//
//     Recorder recorder("run.log", options);      // before the pieces are there
//     simulation.observe(&recorder);
//     simulation.start(...), apply(...), advance(...) ...
//     recorder.finish();
//
// Without a file it only remembers, until save() is asked for:
//
//     Recorder recorder(options);
//     ...
//     recorder.save("run.log");
//
// Without finish(), as when Ctrl+C or a failure throws, the destructor writes what there is and says so on
// standard error. Each start begins a new log, so the file tells the last run.
#pragma once

#include <filesystem>
#include <string>

#include "tools/brittle/replay/body_checks.h"
#include "tools/brittle/replay/log.h"
#include "tools/brittle/run/simulation.h"

namespace brittle::tools {

class Recorder : public SimulationObserver {
  public:
    // `options` is the recipe of the next start's pieces; its world is taken from the start itself.
    Recorder(std::filesystem::path file, const FractureOptions& options);
    explicit Recorder(const FractureOptions& options) : Recorder({}, options) {} // without a file
    ~Recorder() override;
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    // Of what is started from now on.
    void use_recipe(const FractureOptions& options) { options_ = options; }

    // Writes the log, atomically; nothing where nothing was started or no file was named. Throws a Failure.
    void finish();
    // Writes the log so far, atomically, and goes on. Throws a Failure, with exit_usage where nothing was started.
    void save(const std::filesystem::path& file) const;

    void started(const Simulation& simulation, const fracture::Fragments& fragments,
                 const WorldOptions& world) override;
    void acted(uint64_t step, const Action& action) override;
    void stepped(const Simulation& simulation) override;

  private:
    void add_state(const Simulation& simulation);
    // The log so far as `file` is to hold it: paths in it are relative to the file's folder.
    [[nodiscard]] std::string text(const std::filesystem::path& file, const std::string& end) const;

    std::filesystem::path file_;
    FractureOptions options_;
    BodyChecks checks_;
    ReplayLog header_;
    std::string text_; // after the header; empty: nothing was started
    uint64_t steps_ = 0;
    bool finished_ = false;
};

} // namespace brittle::tools
