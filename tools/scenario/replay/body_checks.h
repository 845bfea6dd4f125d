// Check values of bodies in a replay log: for each body that changed in a step, sixteen bits of a hash of its pose and
// velocities. They locate a difference that Simulation::state_hash(), which covers the whole state, has found.
// body_text.h describes their text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "physics/world/world.h"

namespace brittle::tools {

class BodyChecks {
  public:
    // Returns the text for the bodies of the world after the next step.
    [[nodiscard]] std::string next(const physics::World& world);

  private:
    std::vector<std::optional<uint16_t>> last_; // by BodyId::value
};

} // namespace brittle::tools
