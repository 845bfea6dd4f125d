// How long the device took for a pass of the frame graph, and when.
#pragma once

#include <cstdint>
#include <string>

namespace brittle::engine {

struct PassTime {
    std::string name;
    double milliseconds = 0.0; // between the device's timestamps around the pass, barriers included
    // Nanoseconds of std::chrono::steady_clock. Right to some microseconds where Device::has_common_clock();
    // else as if the last pass had ended when its times were read, which is right after the wait for it.
    int64_t begin = 0;
};

} // namespace brittle::engine
