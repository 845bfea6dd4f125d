#include "tools/brittle/base/interrupt.h"

#include <atomic>
#include <csignal>

#include <sys/time.h>
#include <unistd.h>

#include "tools/scenario/base/failure.h"

namespace brittle::tools {

namespace {

constexpr suseconds_t deadline = 400'000; // microseconds

std::atomic<bool> interrupted = false;
std::atomic<int> deadlines = 0; // the number of InterruptDeadline
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
              "a signal handler may touch nothing else");

// Handlers may call what POSIX lists as async-signal-safe; setitimer() is a bare system call.
void start_deadline() {
    const itimerval time{{0, 0}, {0, deadline}};
    ::setitimer(ITIMER_REAL, &time, nullptr);
}

void remember(int signal) {
    interrupted = true;
    std::signal(signal, SIG_DFL);
    if (deadlines > 0) start_deadline();
}

void end_now(int) {
    if (deadlines == 0) return;
    constexpr char message[] = "brittle: interrupted\n";
    [[maybe_unused]] const ssize_t ignored = ::write(STDERR_FILENO, message, sizeof message - 1);
    ::_exit(exit_interrupted);
}

} // namespace

void catch_interrupts() {
    std::signal(SIGINT, remember);
    std::signal(SIGTERM, remember);
    std::signal(SIGALRM, end_now);
}

InterruptDeadline::InterruptDeadline() {
    ++deadlines;
    if (interrupted) start_deadline();
}

InterruptDeadline::~InterruptDeadline() {
    --deadlines;
}

bool is_interrupted() {
    return interrupted;
}

void throw_if_interrupted() {
    if (interrupted) throw Failure(exit_interrupted, "interrupted");
}

} // namespace brittle::tools
