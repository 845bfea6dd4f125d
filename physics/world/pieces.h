// Bodies for all pieces of a fracture: density times volume as mass, the true inertia, a hull that does not
// push neighbours apart (hull.h).
//
// The frame of a piece's body has the input's axes and its origin at the piece's centre of mass: a vertex p
// of the fragments is at (p - piece.mass.centre_of_mass) in the body, and is drawn with the body's pose. At
// birth a pose is that centre of mass moved by the placement, so pieces stand exactly where the mesh stood.
//
//     Result<std::vector<BodyId>> bodies = add_pieces(world, fragments, {.density = 2400.0f});
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "fracture/pieces/fragments.h"
#include "physics/material.h"
#include "physics/world/hull.h"
#include "physics/world/world.h"

namespace brittle::physics {

// How the solid moved when it broke; pieces inherit v + w x r.
struct PlacedMotion {
    Pose placement{};                 // from the coordinates of the fragments to the world
    glm::vec3 linear_velocity{0.0f};  // m/s, of the point at placement.position
    glm::vec3 angular_velocity{0.0f}; // rad/s, world axes
};

// One body a piece, in the order of fragments.pieces. Fails (invalid_mesh, invalid_setting) on non-finite
// positions, vertex ranges outside the arena, or a density that is not positive, naming the piece; then no
// body is added. A piece without volume (a sliver, an open or inside-out shell) gets the mass properties of a
// thin box around it. Where the world has no room for all, the smaller ones are debris (crowd.h).
Result<std::vector<BodyId>> add_pieces(World& world, const fracture::Fragments& fragments,
                                       const Material& material = {}, const PlacedMotion& motion = {},
                                       const HullSettings& hull = {});
// The same with hulls made ahead, one a piece (collision_hulls()). Too few of them, or a missing one, is invalid_setting.
Result<std::vector<BodyId>> add_pieces(World& world, const fracture::Fragments& fragments, const Material& material,
                                       const PlacedMotion& motion, const PieceHulls& hulls);

// All of the bodies but where they will be, one a piece, side by side on so many threads (0: one a core): what can be made
// ahead of the frame in which they come, on any thread. Fails as add_pieces() does.
using PieceForms = std::vector<std::shared_ptr<const BodyForm>>;
[[nodiscard]] Result<PieceForms> piece_forms(const fracture::Fragments& fragments, const Material& material,
                                             const PieceHulls& hulls, uint32_t threads = 0);
// The same with those: less than half a microsecond a body is left. Too few of them, or a missing one, is invalid_setting.
Result<std::vector<BodyId>> add_pieces(World& world, const fracture::Fragments& fragments, const Material& material,
                                       const PlacedMotion& motion, const PieceForms& forms);

} // namespace brittle::physics
