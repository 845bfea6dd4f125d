// Fuzzes the reader of replay logs: a valid log is unchanged after writing and reading it again.
#include "tests/fuzz/oracle.h"
#include "tests/tools/log_text.h"
#include "tools/scenario/base/failure.h"

using namespace brittle;
using namespace brittle::tools;

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
    const std::string text = test::log_text(log, "/");
    const fuzz::MemoryFile again(reinterpret_cast<const uint8_t*>(text.data()), text.size());
    try {
        fuzz::require(test::log_text(read_replay_log(again.path()), "/") == text,
                      "a log that was written is read as another");
    } catch (const Failure& failure) {
        fuzz::require(false, failure.what());
    }
    return 0;
}
