// What a replay log keeps of each body after a step, to tell which one differs: sixteen bits of a hash over
// its pose and velocities, of bodies that changed. Simulation::state_hash() says that something differs, and
// misses nothing.
// body_text.h says how they are written.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "physics/world/world.h"

namespace brittle::tools {

class BodyChecks {
  public:
    // The text of the world's bodies after another step.
    [[nodiscard]] std::string next(const physics::World& world);

  private:
    std::vector<std::optional<uint16_t>> last_; // by BodyId::value
};

} // namespace brittle::tools
