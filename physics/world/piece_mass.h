// Mass and inertia of a piece, also of a sliver whose rounded integrals no rigid body can have.
//
// kg, m, in the axes of the fragments. Pure functions; thread-safe.
#pragma once

#include <span>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "fracture/pieces/fragments.h"
#include "physics/material.h"

namespace brittle::physics {

// Relative tolerance of "no principal moment exceeds the sum of the other two": moments are rounded to float.
inline constexpr double moment_slack = 1e-3;
// Range in which products and inverses fit in single precision: from a grain of dust to a mountain.
inline constexpr float min_mass = 1e-18f, greatest_mass = 1e18f;    // kg
inline constexpr double min_moment = 1e-28, greatest_moment = 1e28; // kg m^2, of the largest principal moment

struct BodyMass {
    double mass = 0.0;       // kg
    glm::dmat3 inertia{0.0}; // kg m^2, about the centre of mass
};

// Fails with invalid_setting on a material without density or strength, and with invalid_mesh on non-finite positions
// or vertex ranges outside the arena, naming the piece.
[[nodiscard]] fracture::Result<void> check_pieces(const fracture::Fragments& fragments, const Material& material);

// Returns density times the piece's integrals. Those of a sliver may round to values that is_possible() rejects.
[[nodiscard]] BodyMass true_mass(const fracture::Piece& piece, double density);

// Returns whether a rigid body can have this mass and inertia: neither is that of less than a grain of dust, and no
// principal moment is above the sum of the other two.
[[nodiscard]] bool is_possible(const BodyMass& body);

// Returns the mass of the points' bounding box, whose sides are at least a thousandth of the longest and a tenth of a
// millimetre.
[[nodiscard]] BodyMass box_mass(std::span<const glm::dvec3> points, double density);

// Returns true_mass() if it is_possible(), else box_mass().
[[nodiscard]] BodyMass piece_mass(const fracture::Fragments& fragments, const fracture::Piece& piece, double density);

} // namespace brittle::physics
