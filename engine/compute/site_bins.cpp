#include "engine/compute/site_bins.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <glm/common.hpp>

namespace brittle::engine {

namespace {

constexpr double sites_per_bin = 2.0;
constexpr double max_bins = 64.0; // along each axis

} // namespace

void SiteBins::build(std::span<const glm::dvec3> positions, const fracture::Box& box) {
    const auto count = static_cast<uint32_t>(positions.size());
    const auto bins = static_cast<uint32_t>(std::clamp(std::round(std::cbrt(count / sites_per_bin)), 1.0, max_bins));
    const glm::dvec3 size = glm::max(box.size() / static_cast<double>(bins), glm::dvec3(1e-9));
    const glm::dvec3 furthest = glm::max(glm::abs(box.min), glm::abs(box.max));
    grid = {.low = glm::vec4(box.min, std::max({furthest.x, furthest.y, furthest.z})),
            .bin_size = glm::vec4(size, 0.0),
            .bins = {bins, bins, bins, 0},
            .counts = glm::uvec4(0)};

    bin_of_.resize(count);
    cursor_.assign(size_t{bins} * bins * bins + 1, 0);
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t bin = 0;
        for (int axis = 2; axis >= 0; --axis) {
            const double at = (positions[i][axis] - box.min[axis]) / size[axis];
            bin = bin * bins + static_cast<uint32_t>(std::clamp(at, 0.0, static_cast<double>(bins - 1)));
        }
        bin_of_[i] = bin;
        ++cursor_[bin + 1];
    }
    for (size_t b = 1; b < cursor_.size(); ++b) cursor_[b] += cursor_[b - 1];
    begin = cursor_;
    sites.resize(count);
    for (uint32_t i = 0; i < count; ++i)
        sites[cursor_[bin_of_[i]]++] = glm::vec4(glm::vec3(positions[i]), std::bit_cast<float>(i));
}

} // namespace brittle::engine
