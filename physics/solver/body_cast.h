// The hulls of a body that another body meets on its way: a shape cast, for code that breaks bodies (World::cast()).
//
// Both bodies go on at their velocities, without contacts, and no hull holds the cast body up. Metres, seconds.
// Thread-safe.
#pragma once

#include <vector>

#include "physics/solver/body.h"
#include "physics/world/world.h"

namespace brittle::physics {

// As World::cast().
[[nodiscard]] std::vector<CastHit> cast_body(const Body& cast, const Body& target, float seconds);

} // namespace brittle::physics
