#include "tools/brittle/base/progress.h"

#include <cstdio>
#include <utility>

#include <unistd.h>

#include "tools/brittle/base/console.h"

namespace brittle::tools {

using namespace std::chrono_literals;

Progress::Progress(std::string label)
    : label_(std::move(label)), terminal_(isatty(STDERR_FILENO) == 1 && !is_quiet()),
      start_(std::chrono::steady_clock::now()), last_(start_) {}

Progress::~Progress() {
    if (shown_) std::fputs("\r\033[K", stderr);
}

void Progress::update(double share) {
    if (!terminal_) return;
    const auto now = std::chrono::steady_clock::now();
    if (shown_ && now - last_ < 100ms) return;
    last_ = now;
    shown_ = true;
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    std::fprintf(stderr, "\r\033[K%s %3.0f %%", label_.c_str(), share * 100.0);
    if (elapsed > 2.0 && share > 0.02) {
        std::fprintf(stderr, ", about %.0f s left", elapsed * (1.0 - share) / share);
    }
    std::fflush(stderr);
}

} // namespace brittle::tools
