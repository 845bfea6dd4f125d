// How long the device took for a pass of the frame graph.
#pragma once

#include <string>

namespace brittle::engine {

struct PassTime {
    std::string name;
    double milliseconds = 0.0; // between the device's timestamps around the pass, barriers included
};

} // namespace brittle::engine
