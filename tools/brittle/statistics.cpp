#include "tools/brittle/statistics.h"

#include <algorithm>
#include <cmath>

namespace brittle::tools {

Statistics statistics(std::vector<double> samples) {
    if (samples.empty()) return {};
    std::sort(samples.begin(), samples.end());
    const size_t n = samples.size();
    const auto rank = static_cast<size_t>(std::ceil(0.95 * static_cast<double>(n)));
    return {.median = (samples[(n - 1) / 2] + samples[n / 2]) / 2.0,
            .p95 = samples[rank - 1],
            .max = samples.back()};
}

} // namespace brittle::tools
