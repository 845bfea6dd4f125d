// One instant on the device's timestamp clock and on std::chrono::steady_clock.
#pragma once

#include <cmath>
#include <cstdint>

namespace brittle::engine {

struct ClockMatch {
    uint64_t ticks = 0;      // the instant on the device's clock, in ticks
    int64_t nanoseconds = 0; // the instant on steady_clock
    double period = 1.0;     // nanoseconds a tick

    // Converts a device timestamp to nanoseconds of steady_clock. The error grows with the distance from the match,
    // because the two clocks drift apart.
    [[nodiscard]] int64_t host(uint64_t timestamp) const {
        return nanoseconds + std::llround(static_cast<double>(static_cast<int64_t>(timestamp - ticks)) * period);
    }
};

} // namespace brittle::engine
