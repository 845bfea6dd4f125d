#pragma once

#include <vector>

namespace brittle::tools {

struct Statistics {
    double median = 0.0;
    double p95 = 0.0;
    double max = 0.0;
};

// Median (the mean of the middle two for an even count), 95th percentile (nearest rank) and maximum; zeros for no sample.
[[nodiscard]] Statistics statistics(std::vector<double> samples);

} // namespace brittle::tools
