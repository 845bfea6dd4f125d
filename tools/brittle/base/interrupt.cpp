#include "tools/brittle/base/interrupt.h"

#include <atomic>
#include <csignal>

#include "tools/brittle/base/failure.h"

namespace brittle::tools {

namespace {

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch nothing else");

void remember(int signal) {
    interrupted = true;
    std::signal(signal, SIG_DFL);
}

} // namespace

void catch_interrupts() {
    std::signal(SIGINT, remember);
    std::signal(SIGTERM, remember);
}

bool is_interrupted() {
    return interrupted;
}

void throw_if_interrupted() {
    if (interrupted) throw Failure(exit_interrupted, "interrupted");
}

} // namespace brittle::tools
