// The range of the numbers that the physics takes from files and people.
#pragma once

namespace brittle::physics {

// Places, velocities and impulses (m, m/s, rad/s, N s) of at most this size keep the cubes that the physics computes of
// them within single precision. World does not check them, programs do. World::apply_impulse() changes a velocity by
// no more than that.
inline constexpr float max_magnitude = 1e9f;

} // namespace brittle::physics
