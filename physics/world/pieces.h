// Rigid bodies for all pieces of a fracture: density times volume as mass, the piece's own inertia, and a hull that
// does not push neighbours apart (hull.h).
//
// A piece's body has the axes of the input and its origin at the piece's centre of mass: vertex p of the fragments is
// at p - piece.mass.centre_of_mass in the body and is drawn with the body's pose. The initial pose is the placement
// applied to the centre of mass, so pieces stand exactly where the mesh stood.
//
// World coordinates, right-handed; metres, kilograms, seconds. add_pieces() follows the thread rule of World.
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

// Placement and motion of the solid when it broke. Pieces inherit v + w x r.
struct PlacedMotion {
    Pose placement{};                 // from the coordinates of the fragments to the world
    glm::vec3 linear_velocity{0.0f};  // m/s, of the point at placement.position
    glm::vec3 angular_velocity{0.0f}; // rad/s, world axes
};

// Adds one body per piece and returns them in the order of fragments.pieces. Fails with invalid_mesh on non-finite
// positions or vertex ranges outside the arena, naming the piece, and with invalid_setting on a density that is not
// positive; then no body is added. A piece without volume (a sliver, an open or inside-out shell) gets the mass
// properties of its bounding box. Where the limit on colliding bodies leaves no room for all pieces, the smaller ones
// are debris (crowd.h).
Result<std::vector<BodyId>> add_pieces(World& world, const fracture::Fragments& fragments,
                                       const Material& material = {}, const PlacedMotion& motion = {},
                                       const HullSettings& hull = {});
// As above with precomputed hulls, one a piece (collision_hulls()). A wrong number of hulls or a null one is
// invalid_setting.
Result<std::vector<BodyId>> add_pieces(World& world, const fracture::Fragments& fragments, const Material& material,
                                       const PlacedMotion& motion, const PieceHulls& hulls);

// Prepares one body form per piece: all of the body except its pose and motion. It may run ahead of time on any
// thread, and uses `threads` threads (0: one a core). Fails as add_pieces() does.
using PieceForms = std::vector<std::shared_ptr<const BodyForm>>;
[[nodiscard]] Result<PieceForms> piece_forms(const fracture::Fragments& fragments, const Material& material,
                                             const PieceHulls& hulls, uint32_t threads = 0);
// As above with precomputed forms; under half a microsecond a body remains. A wrong number of forms or a null one is
// invalid_setting.
Result<std::vector<BodyId>> add_pieces(World& world, const fracture::Fragments& fragments, const Material& material,
                                       const PlacedMotion& motion, const PieceForms& forms);

} // namespace brittle::physics
