// Who is debris because there are too many, whatever its size (WorldSettings::max_colliding).
//
// Five hundred awake pieces that all meet are what a step has time for as they land; twice as many make it nearly twice as
// long, as many more as debris a third. So where pieces come, the largest collide with each other as long as there is room, and the
// rest are debris: they meet the ground, what is fixed and what is large beside them, at least twice as long, but not each other and
// their like: what falls onto a thousand pieces of its size would make a step two and a half times as long. What it costs is that
// they overlap.
//
// - Decided when pieces come, from the state of the world alone, and never again: a run repeats, and nothing begins or
//   ceases to collide while someone looks.
// - As debris grows in number, what comes meets less of what moves: crowding().
// - The largest of a batch collides in any case, as do several pieces that are bonded: they are what is left of what broke.
//   A body that comes alone is such a largest one. Of debris that breaks, which took no room itself, all parts may be debris.
//   So where there is no room a break adds nothing to those that collide, but the largest part of what was held.
//
//     std::vector<Newcomer> batch;
//     for (const Piece& piece : fragments.pieces) batch.push_back({.size = piece.mass.volume});
//     const std::vector<uint8_t> debris = crowded_out(batch, room_in(world));
//     for each piece: desc.debris = debris[i];
//
// Pure functions of their arguments. add_pieces(), Structure and Destruction ask who is debris, World::add_body() does not; it asks for
// crowding().
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/world/world.h"

namespace brittle::physics {

// A body that is about to come, with others at once.
struct Newcomer {
    double size = 0.0;   // volume or mass, the same of all of a batch; what is no number counts as 0
    bool fixed = false;  // takes no room and is no debris
    bool bonded = false; // of several pieces: collides in any case, and takes its room before others
};

// How many more awake bodies may collide with each other; SIZE_MAX without a limit.
[[nodiscard]] size_t room_in(const World& world);

// 1 for each of the batch that is debris, otherwise 0. Of equal sizes the first collide. of_debris: they come of a piece that
// was debris.
[[nodiscard]] std::vector<uint8_t> crowded_out(std::span<const Newcomer> batch, size_t room, bool of_debris = false);

// How many times as long as otherwise must be what debris meets of what moves, if it comes when, itself and its batch included, so
// much debris is awake, small debris too: once, up to twice the limit, then in proportion: twice with three times the limit, thrice
// with four. So the next thousand cost less than the last one did. 1 without a limit.
[[nodiscard]] float crowding(size_t awake_debris, uint32_t max_colliding);

} // namespace brittle::physics
