// The bunny, in pieces that are ready to become bodies: what benchmarks of the world drop. A ball where there is no bunny.
#pragma once

#include <cstddef>
#include <cstdint>

#include <glm/vec3.hpp>

#include "fracture/pieces/fragments.h"
#include "physics/world/pieces.h"
#include "physics/world/world.h"

namespace brittle::tools {

inline constexpr const char* bunny_file = "/usr/share/glmark2/models/bunny.obj"; // assets/SOURCES.md
inline constexpr uint32_t sites_for_1000 = 2400, sites_for_2000 = 5000;          // about so many pieces

struct BrokenBunny {
    fracture::Fragments pieces;
    physics::PieceForms forms;
    double form_milliseconds = 0.0; // of hulls and what else can be made ahead, by all threads together, on the clock

    // So high, in m, standing on the ground.
    explicit BrokenBunny(uint32_t sites, float height = 1.0f);
    // False where the world refuses it.
    [[nodiscard]] bool add_to(physics::World& world, glm::vec3 at) const;
};

// Two thousand pieces that have come to rest five metres away; how many do sleep.
size_t add_sleepers(physics::World& world);

} // namespace brittle::tools
