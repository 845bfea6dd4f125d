// Summary statistics of a list of samples.
#pragma once

#include <vector>

namespace brittle::tools {

struct Statistics {
    double min = 0.0;
    double median = 0.0;
    double p95 = 0.0;
    double p99 = 0.0;
    double max = 0.0;
};

// Returns minimum, median (the mean of the middle two for an even count), 95th and 99th percentile (nearest rank; with
// fewer than 20 or 100 samples this is the maximum) and maximum. All are zero without samples.
[[nodiscard]] Statistics statistics(std::vector<double> samples);

} // namespace brittle::tools
