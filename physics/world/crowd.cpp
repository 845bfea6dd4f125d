#include "physics/world/crowd.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace brittle::physics {

namespace {

double size_of(const BatchBody& one) {
    return one.size > 0.0 ? one.size : 0.0;
}

} // namespace

size_t colliding_room(const World& world) {
    const size_t most = world.settings().max_colliding, there = world.colliding_count();
    return most == 0 ? std::numeric_limits<size_t>::max() : most - std::min(most, there);
}

std::vector<uint8_t> choose_debris(std::span<const BatchBody> batch, size_t room, bool of_debris) {
    std::vector<uint8_t> debris(batch.size(), 0);
    if (batch.size() <= room) return debris;
    const auto larger = [&](size_t a, size_t b) {
        return std::tuple(-size_of(batch[a]), a) < std::tuple(-size_of(batch[b]), b);
    };
    std::vector<size_t> single; // those that can be debris
    size_t bonded = 0, largest = 0;
    for (size_t i = 0; i < batch.size(); ++i) {
        if (larger(i, largest)) largest = i;
        bonded += batch[i].bonded && !batch[i].fixed;
        if (!batch[i].fixed && !batch[i].bonded) single.push_back(i);
    }
    const size_t left = std::min(room - std::min(room, bonded), single.size());
    const auto crowd = single.begin() + static_cast<std::ptrdiff_t>(left);
    std::ranges::nth_element(single, crowd, larger);
    for (auto one = crowd; one != single.end(); ++one) debris[*one] = of_debris || *one != largest;
    return debris;
}

} // namespace brittle::physics
