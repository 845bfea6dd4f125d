// An Engine on stock, unmodified Bullet: the reference of the solver's tests, and a choice of the user
// (WorldSettings::engine).
//
// It differs from World's manual where stock Bullet lacks a feature:
// - No air drag. Debris (WorldSettings::debris_size, BodyDesc::debris) does not collide with other debris, but with all
//   other bodies of any size.
// - Bullet finds one contact point of a pair in a step and accumulates more over time; contacts() lists them. It drops
//   points that slide by a fiftieth of the body's radius in a step: a flat body that slides fast sinks into the ground
//   until it slows. Bullet's swept spheres stop fast bodies at fixed ones. Sleeping depends on speed and time alone.
// - WorldSettings::separation_speed is not read. Overlaps of less than 4 mm are closed by velocity, at up to 0.1 m/s.
// - World::cast() finds nothing: a body that breaks a Structure passes what it has not touched yet without a blow.
// - World::cast_ray() meets hulls with round edges, and may be wrong by a centimetre.
// - Joints are solved row by row: a chain stretches under a heavy load. A joint breaks after the step in which it gave
//   more than its greatest force.
// - A step begins with at most 100,000 m/s and 100,000 rad/s of each body; bodies that are very heavy or spin very fast
//   lose the gyroscopic torque. Bullet computes NaN beyond that.
// - One thread. Bullet keeps globals, so a mutex lets one World on Bullet step at a time; Worlds on the solver do not
//   wait. States repeat for the same calls with one build of Bullet.
//
// Bullet's unit of length is the decimetre here: with metres, its collision detection drops points less than a
// centimetre apart.
#pragma once

#include <memory>

#include "physics/world/engine.h"

namespace brittle::physics {

// Precondition: the settings are valid.
[[nodiscard]] std::unique_ptr<Engine> make_bullet_engine(const WorldSettings& settings);

} // namespace brittle::physics
