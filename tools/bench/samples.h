// What benchmarks say of many times.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace brittle::tools {

// 0 of none.
inline double median(std::vector<double> samples) {
    if (samples.empty()) return 0.0;
    const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
    std::nth_element(samples.begin(), middle, samples.end());
    return *middle;
}
inline double longest(std::span<const double> samples) {
    return samples.empty() ? 0.0 : *std::ranges::max_element(samples);
}

} // namespace brittle::tools
