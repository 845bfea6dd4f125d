// Limits how many awake bodies collide with each other: beyond WorldSettings::max_colliding, new bodies become debris
// whatever their size.
//
// Contacts of debris cost less than those of hulls (solver/debris_solver.h). When a batch of bodies arrives, its largest
// ones keep their hulls as long as there is room, and the rest are debris.
//
// - The decision is made once, when a body is added, from the state of the world alone. Runs repeat, and no body
//   starts or stops colliding in view.
// - The largest body of a batch always collides, and so does a body of several bonded pieces: they are the remains of
//   the object that broke. A body that is added alone is the largest of its batch. If debris breaks, which took no
//   room itself, all parts may be debris. Without room, a break thus adds no colliding bodies except the largest part
//   of a held object.
//
//     std::vector<BatchBody> batch;
//     for (const Piece& piece : fragments.pieces) batch.push_back({.size = piece.mass.volume});
//     const std::vector<uint8_t> debris = choose_debris(batch, colliding_room(world));
//     for each piece: desc.debris = debris[i];
//
// Pure functions; thread-safe. add_pieces(), Structure and Destruction call choose_debris(); World::add_body() does not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/world/world.h"

namespace brittle::physics {

// One body of a batch that is added at once.
struct BatchBody {
    double size = 0.0;   // volume or mass, one kind throughout a batch; NaN counts as 0
    bool fixed = false;  // takes no room and is never debris
    bool bonded = false; // of several pieces: always collides, and takes room before single pieces
};

// Returns how many more awake bodies may collide with each other; SIZE_MAX without a limit.
[[nodiscard]] size_t colliding_room(const World& world);

// Returns 1 for each body of the batch that is debris, else 0. Among equal sizes the first ones collide. of_debris:
// whether the batch comes from a body that was debris.
[[nodiscard]] std::vector<uint8_t> choose_debris(std::span<const BatchBody> batch, size_t room, bool of_debris = false);

} // namespace brittle::physics
