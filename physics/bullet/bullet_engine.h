// A World on stock Bullet, whole and unmodified: the reference that the solver's tests compare with, and a choice of
// the user (WorldSettings::engine).
//
// World's promises that need more than stock Bullet do not hold:
// - No air drag. Debris is marked by WorldSettings::debris_size and BodyDesc::debris; it does not collide with other
//   debris, but with everything else, however small; partner_size_factor() is not applied.
// - Bullet finds one contact of a pair a step and gathers more over time; contacts() has the impulses of those. Fast
//   bodies stop at fixed ones by Bullet's swept spheres. Sleeping is by speed and time alone.
// - One thread. Bullet keeps globals, so a mutex lets one World on Bullet step at a time; Worlds on the solver do not
//   wait. States repeat for the same calls with one build of Bullet.
//
// Bullet counts in decimetres here: in metres its collision detection drops points less than a centimetre apart.
#pragma once

#include <memory>

#include "physics/world/engine.h"

namespace brittle::physics {

// The settings are valid.
[[nodiscard]] std::unique_ptr<Engine> make_bullet_engine(const WorldSettings& settings);

} // namespace brittle::physics
