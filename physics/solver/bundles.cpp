#include "physics/solver/bundles.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "fracture/base/union_find.h"

namespace brittle::physics {

void Bundles::start(size_t movers) {
    parents_.resize(movers);
    std::iota(parents_.begin(), parents_.end(), 0u);
    points_.assign(movers, 0);
    bundles_.assign(movers, none);
    count_ = 0;
}

void Bundles::join(uint32_t a, uint32_t b, uint32_t points) {
    points_[a] += points;
    fracture::unite(parents_, a, b);
}

void Bundles::finish(uint32_t min_points) {
    groups_.clear();
    for (uint32_t mover = 0; mover < parents_.size(); ++mover) {
        const uint32_t group = parents_[mover] = fracture::root_of(parents_, mover);
        if (group != mover)
            points_[group] += points_[mover];
        else
            groups_.push_back(mover);
    }
    std::erase_if(groups_, [this](uint32_t group) { return points_[group] == 0; });
    std::ranges::sort(groups_,
                      [this](uint32_t a, uint32_t b) { return std::pair(points_[b], a) < std::pair(points_[a], b); });
    uint32_t filled = min_points; // points of the last bundle
    for (const uint32_t group : groups_) {
        if (filled >= min_points) {
            ++count_;
            filled = 0;
        }
        bundles_[group] = count_ - 1;
        filled += points_[group];
    }
    for (uint32_t mover = 0; mover < parents_.size(); ++mover) bundles_[mover] = bundles_[parents_[mover]];
}

} // namespace brittle::physics
