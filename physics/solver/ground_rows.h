// Builds the rows of contacts with the ground (row.h), four points at a time: four points of one body, or one point of
// each of four bodies.
//
// In a heap half of all contacts are with the ground, and their rows depend on one body each. The operations and their
// order are those of RowSolver::make_row(), so results are equal bit for bit. Pure functions; thread-safe.
#pragma once

#include <array>
#include <cstddef>

#include <glm/vec3.hpp>

#include "physics/solver/four_rows.h"
#include "physics/solver/manifold.h"
#include "physics/solver/row.h"

namespace brittle::physics {

struct GroundRows {
    // The part of an overlap that a step corrects. It may exceed the part between bodies, because lifting a body off
    // the static ground lifts no other body into overlap.
    static constexpr float correction_part = 0.6f;

    FourRows contacts, frictions; // n of a friction row is its tangent
    Four speed;                   // m/s, approach speed before the step's gravity: -J v_0
    Four correction;              // N s, bias of the split impulse; 0 without overlap
};

struct GroundStep {
    float seconds;
    glm::vec3 gravity;
    float min_bounce_speed; // m/s; slower impacts do not bounce
    float warm_start_part;  // part of the last impulse from which lambda starts
};

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
    Float4 inverse_mass, restitution, friction;
};
// Returns the rows of the point with that index of each body; zero rows for a body with fewer points.
[[nodiscard]] GroundRows ground_rows(const FourGrounded& bodies, size_t index, const GroundStep& step);

} // namespace brittle::physics
