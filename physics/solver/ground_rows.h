// Rows of hulls' contacts with the ground, four points at a time: of one body, or one of each of four.
//
// In a heap half of all contacts are those, and each waits for nothing but its body. The same operations as one at a time, in the same
// order (RowSolver::make_row()): not a bit is different. Bullet's units. Thread-safe: no state.
#pragma once

#include <array>
#include <cstddef>

#include "physics/solver/four_rows.h"
#include "physics/solver/ground_contact.h"
#include "physics/solver/row.h"

namespace brittle::physics {

struct GroundRows {
    // Of an overlap, in a step. The ground yields to nobody, so it may be more than between bodies, where each piece that is lifted
    // lifts others.
    static constexpr float undone_part = 0.6f;

    FourRows contacts, frictions; // frictions act along their normals
    Four speed;                   // at which the body comes down, before the step's gravity
    Four depth;                   // wanted where overlap is undone; 0: there is none
};

struct GroundStep {
    float seconds;
    btVector3 gravity;
    float min_bounce_speed; // slower blows do not bounce
    float kept_impulse;     // the part of the last impulse to start from
};

// Of four points from one on; where there are fewer, the last one again. The body does not rest.
[[nodiscard]] GroundRows ground_rows(const Mover& mover, const GroundManifold& ground, size_t first,
                                     const GroundStep& step);

// Four bodies that do not rest, side by side, and what they touch the ground in.
struct FourGrounded {
    FourGrounded(const std::array<const Mover*, 4>& movers, const std::array<const GroundManifold*, 4>& manifolds);

    std::array<const GroundManifold*, 4> grounds;
    std::array<FourVectors, 3> turning;
    FourVectors centre, linear, angular;
    Float4 light, restitution, friction;
};
// Of a point of each, the one with that index; who has fewer has rows without effect.
[[nodiscard]] GroundRows ground_rows(const FourGrounded& bodies, size_t index, const GroundStep& step);

} // namespace brittle::physics
