// The device time of a pass of the frame graph.
#pragma once

#include <cstdint>
#include <string>

namespace brittle::engine {

struct PassTime {
    std::string name;
    double milliseconds = 0.0; // between the device's timestamps around the pass, barriers included
    // The start, in nanoseconds of std::chrono::steady_clock. Accurate to microseconds with Device::has_common_clock().
    // Without it, the end of the last pass is assumed to be the moment at which the times were read, right after the
    // wait for the frame.
    int64_t begin = 0;
};

} // namespace brittle::engine
