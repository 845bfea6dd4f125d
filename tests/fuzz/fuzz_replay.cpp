// Fuzzes replay logs: a valid log is unchanged after writing and reading it again, and its run breaks no promise
// (run_checks.h) and ends in the same state when it is repeated. The states of a changed log are not those of its run.
#include <algorithm>
#include <vector>

#include "tests/fuzz/oracle.h"
#include "tests/fuzz/run_checks.h"
#include "tests/tools/log_text.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/replay/player.h"

using namespace brittle;
using namespace brittle::tools;

namespace {

constexpr size_t max_actions = 20;

// Returns whether the bytes are a log.
bool read(const uint8_t* data, size_t size, ReplayLog& log) {
    const fuzz::TimeGuard guard;
    const fuzz::MemoryFile file(data, size);
    try {
        log = read_replay_log(file.path());
    } catch (const Failure& failure) {
        fuzz::require(failure.code() == exit_input, "a damaged log is an input error");
        fuzz::check_message(failure.what());
        return false;
    }
    return true;
}

void check_text(const ReplayLog& log) {
    const std::string text = test::log_text(log, "/");
    const fuzz::MemoryFile again(reinterpret_cast<const uint8_t*>(text.data()), text.size());
    try {
        fuzz::require(test::log_text(read_replay_log(again.path()), "/") == text,
                      "a log that was written is read as another");
    } catch (const Failure& failure) {
        fuzz::require(false, failure.what());
    }
}

// Schedules the actions that fit the run's pieces, whose number a changed log gets wrong.
void schedule_fitting(ReplayLog log, Simulation& simulation) {
    const size_t pieces = simulation.destruction() ? UINT32_MAX : simulation.piece_count();
    std::erase_if(log.actions, [&](const auto& entry) { return !fault_of(entry.second, pieces).empty(); });
    schedule(log, simulation);
}

// Returns the hash of the last state.
uint64_t run(const ReplayLog& log) {
    Simulation simulation(log.recipe.material);
    Player player(log);
    simulation.observe(&player);
    follow(log, simulation);
    fuzz::run(log.recipe, simulation, std::min<uint64_t>(log.states.size() + 2, fuzz::max_steps),
              [&] { schedule_fitting(log, simulation); });
    return simulation.state_hash();
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    ReplayLog log;
    if (!read(data, size, log)) return 0;
    check_text(log);
    if (!fuzz::bound(log.recipe)) return 0;
    log.actions.resize(std::min(log.actions.size(), max_actions));
    const fuzz::TimeGuard guard(2.0 * fuzz::max_run_seconds);
    fuzz::run_or_fail([&] { fuzz::require(run(log) == run(log), "two equal runs end in different states"); });
    return 0;
}
