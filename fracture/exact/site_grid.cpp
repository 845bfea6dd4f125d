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

// Bins are found by a rounded division: a site may lie this share of a bin outside its own.
constexpr double kBinSlack = 1e-9;

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
      origin_(glm::clamp(sites[c], grid.region_.min, grid.region_.max)),
      slack_(kBinSlack * std::max({grid.bin_size_.x, grid.bin_size_.y, grid.bin_size_.z})) {}

void SiteGrid::Walk::visit_bin(int x, int y, int z, const Reach& reach) {
    const uint32_t bin = grid_.bin_index(x, y, z);
    const glm::dvec3 c = sites_[c_];
    for (uint32_t k = grid_.bin_begin_[bin]; k < grid_.bin_begin_[bin + 1]; ++k) {
        const SiteId s = grid_.bin_sites_[k];
        const glm::dvec3 n = sites_[s] - c;
        const double d2 = squared(n);
        const bool near = d2 <= reach.radius2 && n.x >= reach.low.x && n.x <= reach.high.x
                          && n.y >= reach.low.y && n.y <= reach.high.y && n.z >= reach.low.z
                          && n.z <= reach.high.z;
        if (near && s != c_) batch_.push_back({d2, s});
    }
}

bool SiteGrid::Walk::next(const Reach& reach) {
    // Bins are found by a rounded division: a site may lie a hair outside its own.
    const glm::ivec3 first = grid_.bin_of(sites_[c_] + reach.low - slack_);
    const glm::ivec3 last = grid_.bin_of(sites_[c_] + reach.high + slack_);
    for (;; ++ring_) {
        const int r = ring_;
        const glm::ivec3 low = home_ - r;
        const glm::ivec3 high = home_ + r;
        const bool all_visited = low.x < first.x && low.y < first.y && low.z < first.z && high.x > last.x
                                 && high.y > last.y && high.z > last.z;
        if (all_visited) return false;
        // A site in a bin is no nearer than the bin is, seen from the point of the region nearest to c
        // (moving both points into a convex region brings them no farther apart).
        const auto slab2 = [&](int k, int index) {
            const double inside = origin_[k] - grid_.region_.min[k];
            const double gap =
                std::max(index * grid_.bin_size_[k] - inside, inside - (index + 1) * grid_.bin_size_[k])
                - slack_;
            return gap > 0.0 ? gap * gap : 0.0;
        };
        double nearest2 = std::numeric_limits<double>::infinity(); // of all bins of this ring and beyond
        for (int k = 0; k < 3 && r > 0; ++k) {
            if (low[k] >= first[k]) nearest2 = std::min(nearest2, slab2(k, low[k]));
            if (high[k] <= last[k]) nearest2 = std::min(nearest2, slab2(k, high[k]));
        }
        if (r > 0 && nearest2 > reach.radius2) return false;
        batch_.clear();
        for (int z = std::max(low.z, first.z); z <= std::min(high.z, last.z); ++z) {
            const double z2 = slab2(2, z);
            if (z2 > reach.radius2) continue;
            for (int y = std::max(low.y, first.y); y <= std::min(high.y, last.y); ++y) {
                const double zy2 = z2 + slab2(1, y);
                if (zy2 > reach.radius2) continue;
                const bool shell = z == low.z || z == high.z || y == low.y || y == high.y;
                const int step = shell || r == 0 ? 1 : 2 * r; // inside the shell only its two ends are new
                for (int x = low.x; x <= high.x; x += step) {
                    if (x >= first.x && x <= last.x && zy2 + slab2(0, x) <= reach.radius2)
                        visit_bin(x, y, z, reach);
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
