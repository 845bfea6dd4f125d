#include "fracture/exact/site_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace brittle::fracture::exact {

namespace {

// Fewer sites a bin visit more bins in vain, more sites a bin sort more that are too far.
constexpr double kSitesPerBin = 2.0;
constexpr int kMostBins = 128; // along an axis

// Sites spread this many times wider than the box would leave the box with few bins: the grid then covers the
// box alone, and sites outside it are kept in the bins nearest to them.
constexpr double kWidestRegion = 4.0;

uint64_t hash_of(const glm::dvec3& p) {
    uint64_t h = 0;
    for (int k = 0; k < 3; ++k) {
        const double x = p[k] + 0.0; // -0 equals +0
        uint64_t bits;
        std::memcpy(&bits, &x, sizeof bits);
        h = (h ^ bits) * 0x9e3779b97f4a7c15ull;
        h ^= h >> 29;
    }
    return h;
}

double squared(const glm::dvec3& v) {
    return v.x * v.x + v.y * v.y + v.z * v.z;
}

} // namespace

void SiteGrid::find_duplicates(std::span<const glm::dvec3> sites) {
    constexpr uint32_t kEmpty = 0xffffffffu;
    const size_t slots = std::bit_ceil(2 * sites.size());
    scratch_.assign(slots, kEmpty);
    owns_cell_.assign(sites.size(), 1);
    for (uint32_t i = 0; i < sites.size(); ++i) { // in index order, so the lowest index comes first
        size_t slot = hash_of(sites[i]) & (slots - 1);
        while (scratch_[slot] != kEmpty && sites[scratch_[slot]] != sites[i]) slot = (slot + 1) & (slots - 1);
        if (scratch_[slot] == kEmpty)
            scratch_[slot] = i;
        else
            owns_cell_[i] = 0;
    }
}

void SiteGrid::build(std::span<const glm::dvec3> sites, const Box& box) {
    find_duplicates(sites);
    Box spread{sites[0], sites[0]};
    for (const glm::dvec3& s : sites) {
        spread.min = glm::min(spread.min, s);
        spread.max = glm::max(spread.max, s);
    }
    const glm::dvec3 wide = spread.size();
    const glm::dvec3 box_size = box.size();
    const bool sprawling = wide.x > kWidestRegion * box_size.x || wide.y > kWidestRegion * box_size.y
                           || wide.z > kWidestRegion * box_size.z;
    region_ = sprawling ? box : spread;

    // Cubic bins as far as the region allows; a flat region gets one layer.
    const glm::dvec3 size = region_.size();
    const double longest = std::max({size.x, size.y, size.z});
    const glm::dvec3 fat = glm::max(size, glm::dvec3(longest * 1e-3));
    const double bins = std::max(1.0, static_cast<double>(sites.size()) / kSitesPerBin);
    const double edge = std::cbrt(fat.x * fat.y * fat.z / bins);
    for (int k = 0; k < 3; ++k) {
        const double n = edge > 0.0 ? size[k] / edge : 1.0;
        bins_[k] = static_cast<int>(std::clamp(std::round(n), 1.0, static_cast<double>(kMostBins)));
        bin_size_[k] = size[k] / bins_[k];
    }

    // Counting sort by bin, stable in the site's index.
    const uint32_t total = static_cast<uint32_t>(bins_.x * bins_.y * bins_.z);
    bin_begin_.assign(total + 1, 0);
    scratch_.assign(sites.size(), total);
    for (uint32_t i = 0; i < sites.size(); ++i) {
        if (!owns_cell_[i]) continue;
        const glm::ivec3 bin = bin_of(sites[i]);
        scratch_[i] = bin_index(bin.x, bin.y, bin.z);
        ++bin_begin_[scratch_[i] + 1];
    }
    for (uint32_t b = 0; b < total; ++b) bin_begin_[b + 1] += bin_begin_[b];
    bin_sites_.resize(bin_begin_[total]);
    std::vector<uint32_t>& cursor = bin_begin_;
    for (uint32_t i = 0; i < sites.size(); ++i) {
        if (scratch_[i] < total) bin_sites_[cursor[scratch_[i]]++] = i;
    }
    for (uint32_t b = total; b > 0; --b) cursor[b] = cursor[b - 1];
    cursor[0] = 0;
}

glm::ivec3 SiteGrid::bin_of(const glm::dvec3& p) const {
    glm::ivec3 bin(0);
    for (int k = 0; k < 3; ++k) {
        if (bins_[k] == 1) continue;
        const double last = bins_[k] - 1;
        bin[k] = static_cast<int>(std::clamp((p[k] - region_.min[k]) / bin_size_[k], 0.0, last));
    }
    return bin;
}

SiteGrid::Walk::Walk(const SiteGrid& grid, std::span<const glm::dvec3> sites, SiteId c,
                     std::vector<Candidate>& memory)
    : grid_(grid), sites_(sites), c_(c), batch_(memory), home_(grid.bin_of(sites[c])),
      origin_(glm::clamp(sites[c], grid.region_.min, grid.region_.max)) {}

void SiteGrid::Walk::visit_bin(int x, int y, int z, double reach2) {
    const uint32_t bin = grid_.bin_index(x, y, z);
    for (uint32_t k = grid_.bin_begin_[bin]; k < grid_.bin_begin_[bin + 1]; ++k) {
        const SiteId s = grid_.bin_sites_[k];
        if (s == c_) continue;
        const double d2 = squared(sites_[s] - sites_[c_]);
        if (d2 <= reach2) batch_.push_back({d2, s});
    }
}

bool SiteGrid::Walk::next(double reach2) {
    const glm::ivec3 bins = grid_.bins_;
    for (;; ++ring_) {
        const int r = ring_;
        const glm::ivec3 low = home_ - r;
        const glm::ivec3 high = home_ + r;
        const bool all_visited =
            low.x < 0 && low.y < 0 && low.z < 0 && high.x >= bins.x && high.y >= bins.y && high.z >= bins.z;
        if (all_visited) return false;
        if (r > 0) {
            // The nearest that a site of this ring can be: the border of the block of rings before it, seen
            // from the point of the region nearest to c (moving both points into a convex region brings them
            // no farther apart). Bins are found by rounded division, hence the slack.
            double border = std::numeric_limits<double>::infinity();
            for (int k = 0; k < 3; ++k) {
                const double inside = origin_[k] - grid_.region_.min[k];
                const double from_low = inside - (low[k] + 1) * grid_.bin_size_[k];
                const double to_high = high[k] * grid_.bin_size_[k] - inside;
                if (low[k] >= 0) border = std::min(border, from_low);
                if (high[k] < bins[k]) border = std::min(border, to_high);
            }
            border -= 1e-9 * std::max({grid_.bin_size_.x, grid_.bin_size_.y, grid_.bin_size_.z});
            if (border > 0.0 && border * border > reach2) return false;
        }
        batch_.clear();
        for (int z = std::max(low.z, 0); z <= std::min(high.z, bins.z - 1); ++z) {
            for (int y = std::max(low.y, 0); y <= std::min(high.y, bins.y - 1); ++y) {
                const bool shell = z == low.z || z == high.z || y == low.y || y == high.y;
                if (shell || r == 0) {
                    for (int x = std::max(low.x, 0); x <= std::min(high.x, bins.x - 1); ++x) {
                        visit_bin(x, y, z, reach2);
                    }
                } else {
                    if (low.x >= 0) visit_bin(low.x, y, z, reach2);
                    if (high.x < bins.x) visit_bin(high.x, y, z, reach2);
                }
            }
        }
        if (batch_.empty()) continue;
        ++ring_;
        std::sort(batch_.begin(), batch_.end());
        return true;
    }
}

} // namespace brittle::fracture::exact
