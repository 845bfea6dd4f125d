// Rows of hulls' contacts with the ground, four points at a time: of one body, or one point of each of four bodies.
//
// In a heap half of all contacts are with the ground, and a row there depends on no other body. The operations and
// their order are those of RowSolver::make_row(): not a bit differs. Thread-safe: no state.
#pragma once

#include <array>
#include <cstddef>

#include <glm/vec3.hpp>

#include "physics/solver/four_rows.h"
#include "physics/solver/manifold.h"
#include "physics/solver/row.h"

namespace brittle::physics {

struct GroundRows {
    // The part of an overlap that a step corrects. The ground is static, so it may be more than between bodies, where
    // each piece that is lifted lifts others.
    static constexpr float correction_part = 0.6f;

    FourRows contacts, frictions; // the normals of frictions are their tangents
    Four speed;                   // m/s, at which the body comes down, before the step's gravity
    Four correction;              // bias of the split impulse that corrects overlap, N s; 0: there is none
};

struct GroundStep {
    float seconds;
    glm::vec3 gravity;
    float min_bounce_speed; // m/s; slower impacts do not bounce
    float warm_start_part;  // of the last impulse
};

// Makes the rows of four points from `first` on; where there are fewer, the last point repeats. The body is not
// resting.
[[nodiscard]] GroundRows ground_rows(const SolverBody& body, const GroundManifold& ground, size_t first,
                                     const GroundStep& step);

// Four bodies that are not resting, side by side, and their contacts with the ground.
struct FourGrounded {
    FourGrounded(const std::array<const SolverBody*, 4>& bodies, const std::array<const GroundManifold*, 4>& manifolds);

    std::array<const GroundManifold*, 4> grounds;
    std::array<FourVectors, 3> inverse_inertia;
    FourVectors centre, linear, angular;
    Float4 inverse_mass, restitution, friction;
};
// Makes the rows of the point with that index of each; a body with fewer points has rows without effect.
[[nodiscard]] GroundRows ground_rows(const FourGrounded& bodies, size_t index, const GroundStep& step);

} // namespace brittle::physics
