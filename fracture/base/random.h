// A pseudo-random generator whose numbers are equal on every compiler and platform; std:: distributions differ.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "fracture/base/box.h"

namespace brittle::fracture {

// SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014). A value type: a copy
// forks the sequence.
class Random {
  public:
    explicit Random(uint64_t seed) : state_(seed) {}

    uint64_t next() {
        uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return z ^ (z >> 31);
    }

    // Returns a number uniform in [0, 1), with 53 random bits.
    double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

    // Returns a point uniform in the box. Draws x, then y, then z.
    glm::dvec3 uniform_in(const Box& box) {
        const double x = uniform();
        const double y = uniform();
        const double z = uniform();
        return box.min + glm::dvec3(x, y, z) * box.size();
    }

  private:
    uint64_t state_;
};

} // namespace brittle::fracture
