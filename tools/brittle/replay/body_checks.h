// What a replay log keeps of each body after a step, to tell which one differs: sixteen bits of a hash over
// its pose and velocities, of bodies that changed. World::state_hash() says that something differs, and
// misses nothing.
//
// As text, in body order: four hexadecimal digits for a body, `(3)` for three bodies in a row that are as
// they were after the step before.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "physics/world.h"

namespace brittle::tools {

class BodyChecks {
  public:
    // The text of the world's bodies after another step.
    [[nodiscard]] std::string next(const physics::World& world);

  private:
    std::vector<std::optional<uint16_t>> last_; // by BodyId::value
};

// How many bodies a text is about; nothing if it is no such text.
[[nodiscard]] std::optional<uint64_t> count_bodies(std::string_view text);

// The first body, in order, for which the texts differ, both of as many bodies. Nothing where they agree.
[[nodiscard]] std::optional<uint64_t> first_difference(std::string_view a, std::string_view b);

} // namespace brittle::tools
