// Seeds of what comes of what, for Destruction: pieces and blows.
#pragma once

#include <cstdint>

#include "fracture/base/random.h"

namespace brittle::physics {

// Of a child: differs for all pieces of all objects, and is the same in every run.
[[nodiscard]] inline uint64_t seed_of(uint64_t parent, uint64_t child) {
    return fracture::Random(parent ^ (0x9e3779b97f4a7c15ull * (child + 1))).next();
}

} // namespace brittle::physics
