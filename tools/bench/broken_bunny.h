// The bunny in pieces that are ready to become bodies, for benchmarks of the world. A ball where the bunny is not
// installed.
#pragma once

#include <cstddef>
#include <cstdint>

#include <glm/vec3.hpp>

#include "fracture/pieces/fragments.h"
#include "physics/world/pieces.h"
#include "physics/world/world.h"

namespace brittle::tools {

inline constexpr const char* bunny_file = "/usr/share/glmark2/models/bunny.obj"; // assets/SOURCES.md
inline constexpr uint32_t sites_for_1000 = 2400, sites_for_2000 = 5000;          // for about 1,000 and 2,000 pieces

struct BrokenBunny {
    fracture::Fragments pieces;
    physics::PieceForms forms;
    double form_milliseconds = 0.0; // wall time of making the forms, on all threads

    // Stands on the ground; height in m.
    explicit BrokenBunny(uint32_t sites, float height = 1.0f);
    // False if the world rejects a body.
    [[nodiscard]] bool add_to(physics::World& world, glm::vec3 at) const;
};

// Adds two thousand resting pieces five metres away, and returns the number that sleep.
size_t add_sleepers(physics::World& world);

} // namespace brittle::tools
