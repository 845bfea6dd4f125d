// Seeds of a Destruction's objects, pieces and blows, each derived from its parent's.
#pragma once

#include <cstdint>

#include "fracture/base/random.h"

namespace brittle::physics {

// Seed of a child by its number; equal in every run, different for all children of all parents.
[[nodiscard]] inline uint64_t seed_of(uint64_t parent, uint64_t child) {
    return fracture::Random(parent ^ (0x9e3779b97f4a7c15ull * (child + 1))).next();
}

} // namespace brittle::physics
