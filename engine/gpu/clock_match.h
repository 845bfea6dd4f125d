// One moment on the device's clock and on std::chrono::steady_clock.
#pragma once

#include <cmath>
#include <cstdint>

namespace brittle::engine {

struct ClockMatch {
    uint64_t ticks = 0;      // of the device's timestamps
    int64_t nanoseconds = 0; // of steady_clock
    double period = 1.0;     // nanoseconds a tick

    // When a timestamp was taken, in nanoseconds of steady_clock. Exact near the match; drifts with the clocks.
    [[nodiscard]] int64_t host(uint64_t timestamp) const {
        return nanoseconds + std::llround(static_cast<double>(static_cast<int64_t>(timestamp - ticks)) * period);
    }
};

} // namespace brittle::engine
