// Replay logs. One that can be read is the same after writing and reading it again.
#include "tests/fuzz/oracle.h"
#include "tools/brittle/failure.h"
#include "tools/brittle/replay/log.h"

using namespace brittle;
using namespace brittle::tools;

namespace {

std::string written(const ReplayLog& log) {
    std::string text = header_line(log, "/");
    size_t action = 0;
    for (uint64_t step = 0; step < log.states.size(); ++step) {
        text += state_line(step, log.states[step]);
        for (; action < log.actions.size() && log.actions[action].first == step; ++action)
            text += action_line(step, log.actions[action].second);
    }
    return text + end_line(log.states.size() - 1, log.end);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const fuzz::MemoryFile file(data, size);
    const fuzz::TimeGuard guard;
    ReplayLog log;
    try {
        log = read_replay_log(file.path());
    } catch (const Failure& failure) {
        fuzz::require(failure.code() == exit_input, "a damaged log is an input error");
        fuzz::check_message(failure.what());
        return 0;
    }
    const std::string text = written(log);
    const fuzz::MemoryFile again(reinterpret_cast<const uint8_t*>(text.data()), text.size());
    try {
        fuzz::require(written(read_replay_log(again.path())) == text,
                      "a log that was written is read as another");
    } catch (const Failure& failure) {
        fuzz::require(false, failure.what());
    }
    return 0;
}
