// Adds the passes of a device to a series and to a time line.
#pragma once

#include <cmath>
#include <vector>

#include "engine/graph/pass_time.h"
#include "tools/brittle/profile/series.h"
#include "tools/brittle/profile/trace.h"

namespace brittle::tools {

inline void add_passes(Series& series, const std::vector<engine::PassTime>& passes) {
    for (const engine::PassTime& pass : passes) series.add("pass " + pass.name, pass.milliseconds);
}

inline void trace_passes(Trace& trace, Track track, const std::vector<engine::PassTime>& passes) {
    for (const engine::PassTime& pass : passes)
        trace.add(track, 0, pass.name, pass.begin, pass.begin + std::llround(pass.milliseconds * 1e6));
}

} // namespace brittle::tools
