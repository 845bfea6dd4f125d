// Mass and inertia of a piece of a fracture, also of one whose own integrals are none that a body can have.
//
// kg, m, in the axes of the fragments. Pure functions.
#pragma once

#include <span>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "fracture/pieces/fragments.h"
#include "physics/material.h"

namespace brittle::physics {

struct BodyMass {
    double mass = 0.0;       // kg
    glm::dmat3 inertia{0.0}; // kg m^2, about the centre of mass
};

// Fails (invalid_setting, invalid_mesh) on a material without density or strength, non-finite positions and
// vertex ranges outside the arena, naming the piece.
[[nodiscard]] fracture::Result<void> check_pieces(const fracture::Fragments& fragments, const Material& material);

// From the piece's integrals; a sliver's can round to what no body has.
[[nodiscard]] BodyMass true_mass(const fracture::Piece& piece, double density);

// Whether a rigid body can have it: positive mass, principal moments of which none exceeds the sum of the others.
[[nodiscard]] bool is_possible(const BodyMass& body);

// Of a box around the points, no side of which is below a thousandth of the longest.
[[nodiscard]] BodyMass box_mass(std::span<const glm::dvec3> points, double density);

// The true mass if a body can have it, else that of the box.
[[nodiscard]] BodyMass piece_mass(const fracture::Fragments& fragments, const fracture::Piece& piece, double density);

} // namespace brittle::physics
