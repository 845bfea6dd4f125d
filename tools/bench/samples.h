// Statistics of benchmark samples.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace brittle::tools {

// 0 without samples.
inline double median(std::vector<double> samples) {
    if (samples.empty()) return 0.0;
    const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
    std::nth_element(samples.begin(), middle, samples.end());
    return *middle;
}
// The smallest sample that at least 95 of a hundred do not exceed; 0 without samples.
inline double percentile_95(std::vector<double> samples) {
    if (samples.empty()) return 0.0;
    const auto at = samples.begin() + static_cast<std::ptrdiff_t>((samples.size() * 95 + 99) / 100 - 1);
    std::nth_element(samples.begin(), at, samples.end());
    return *at;
}
// Over several runs of equal length: statistic(times) of each step, where times holds one sample a run.
std::vector<double> by_step(std::span<const std::vector<double>> runs, const auto& statistic) {
    std::vector<double> result;
    for (size_t step = 0; step < runs[0].size(); ++step) {
        std::vector<double> same;
        for (const std::vector<double>& run : runs) same.push_back(run[step]);
        result.push_back(statistic(same));
    }
    return result;
}
inline double longest(std::span<const double> samples) {
    return samples.empty() ? 0.0 : *std::ranges::max_element(samples);
}
inline double least(std::span<const double> samples) {
    return samples.empty() ? 0.0 : *std::ranges::min_element(samples);
}

} // namespace brittle::tools
