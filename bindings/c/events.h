// Poses and changes of pieces, as the C interface gives them out. Internal.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>

#include "bindings/c/brittle.h"
#include "physics/cutting/destruction.h"
#include "physics/world/world.h"

struct brittle_events {
    std::vector<glm::uvec2> removed, fading;
    std::vector<float> shares;
    struct Added {
        uint32_t row[5];
        brittle::physics::SolidPtr solid;
    };
    std::vector<Added> added;
};

namespace brittle::c {

[[nodiscard]] brittle_events* events_of(physics::DestructionEvents taken);

// Position: three floats; orientation: four.
void put(const physics::Pose& pose, float* position, float* orientation);

// Fills in the transforms of pieces, and counts them.
class Transforms {
  public:
    // Of `out`, which may be null, at most `capacity` are written.
    Transforms(const physics::Destruction& destruction, brittle_transform* out, uint64_t capacity);
    // Of pieces that are never cut: the number of a piece is its slot.
    Transforms(brittle_transform* out, uint64_t capacity) : out_(out), capacity_(capacity) {}

    void add(uint32_t slot, const physics::Pose& pose);
    [[nodiscard]] uint64_t count() const { return count_; }

  private:
    std::vector<physics::PieceId> piece_of_; // by slot; empty: the same number
    brittle_transform* out_;
    uint64_t capacity_;
    uint64_t count_ = 0;
};

} // namespace brittle::c
