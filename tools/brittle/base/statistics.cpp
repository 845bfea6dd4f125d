#include "tools/brittle/base/statistics.h"

#include <algorithm>

namespace brittle::tools {

Statistics statistics(std::vector<double> samples) {
    if (samples.empty()) return {};
    std::sort(samples.begin(), samples.end());
    const size_t n = samples.size();
    const auto percentile = [&](size_t percent) { return samples[(n * percent + 99) / 100 - 1]; };
    return {.min = samples.front(),
            .median = (samples[(n - 1) / 2] + samples[n / 2]) / 2.0,
            .p95 = percentile(95),
            .p99 = percentile(99),
            .max = samples.back()};
}

} // namespace brittle::tools
