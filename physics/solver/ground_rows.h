// Builds the rows of contacts with the ground (row.h), four points at a time: four points of one body, or one point of
// each of four bodies.
//
// In a heap half of all contacts are with the ground, and their rows depend on one body each. The equations are those
// of RowSolver::make_row(); results may differ by rounding. Pure functions; thread-safe.
#pragma once

#include <array>
#include <cstddef>

#include <glm/vec3.hpp>

#include "physics/solver/four_rows.h"
#include "physics/solver/manifold.h"
#include "physics/solver/row.h"

namespace brittle::physics {

struct GroundRows {
    FourRows contacts;
    FourFrictions frictions; // along tangents_of_ground()
    Four speed;              // m/s, approach speed before the step's gravity: -J v_0
};

struct GroundStep {
    float min_bounce_speed; // m/s; slower impacts do not bounce
};

// The tangents of friction rows on the ground.
[[nodiscard]] const Tangents& tangents_of_ground();

// Returns the rows of four points of one body from `first` on; the last point fills up missing ones. Precondition: the
// body is not resting.
[[nodiscard]] GroundRows ground_rows(const SolverBody& body, const GroundManifold& ground, size_t first,
                                     const GroundStep& step);

// Four bodies in lanes, none of them resting, and their contacts with the ground.
struct FourGrounded {
    FourGrounded(const std::array<const SolverBody*, 4>& bodies, const std::array<const GroundManifold*, 4>& manifolds);

    std::array<const GroundManifold*, 4> grounds;
    std::array<FourVectors, 3> inverse_inertia;
    FourVectors centre, linear, angular;
    Float4 inverse_mass, restitution, friction, slop, share;
};
// Returns the rows of the point with that index of each body; zero rows for a body with fewer points.
[[nodiscard]] GroundRows ground_rows(const FourGrounded& bodies, size_t index, const GroundStep& step);

} // namespace brittle::physics
