// The contacts between pieces that come from elsewhere: from files, or from different objects of a scene.
//
//     Result<std::vector<Bond>> bonds = find_contacts(fragments);            // of pieces that were read from a file
//     Result<std::vector<Bond>> glue = find_contacts(surfaces, {.tolerance = 1e-3, .wanted = of_two_objects});
//
// Two faces are in contact where they are opposite, lie in one plane within the tolerance, and overlap. The overlaps of
// two pieces make one bond: its area is their sum, its centroid their mean by area, its normal the mean from a to b. A
// large contact may be divided into cells, each with a bond of its own.
//
// Method: Mueller, Chentanez and Kim, "Real Time Dynamic Fracture with Volumetric Approximate Convex Decompositions",
// SIGGRAPH 2013: faces sorted by |d| of their plane n . x + d = 0 have their opposite faces next to them. Deviations:
// - The sort is per pair of blocks (up to 128 triangles of one piece) whose boxes touch, and takes the triangles near
//   both, with the origin in the middle of them. Many pieces with faces in one plane thus cost no quadratic time, and
//   pieces far from the origin lose no digits.
// - The overlap of two triangles is a polygon, by Sutherland-Hodgman clipping; the faces need not be equal.
//
// Faces without area make no contact, and faces that share a point or an edge only make none. Pieces that reach into
// each other have contacts at opposite faces alone: two equal boxes at one place have none. A piece that is thinner than
// the tolerance may touch with both of its sides. Surfaces may be open.
//
// Metres. Pure functions; thread-safe. The time is that of sorting boxes and near triangles.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture {

struct ContactGrid {
    glm::dvec3 origin{0.0};                                // a corner of a cell
    double size = std::numeric_limits<double>::infinity(); // m, > 0, of a cell; infinity: undivided
};

struct ContactSettings {
    // m, >= 0; the largest distance between the planes of two faces anywhere in their overlap. Rounding in a file of
    // single precision is below the default; gaps that a person leaves may be larger.
    double tolerance = 1e-4;
    // Whether contacts between two pieces are looked for, a < b; empty: between all.
    std::function<bool(uint32_t a, uint32_t b)> wanted{};
    // The grid that divides the contacts of two pieces, along the two coordinates that vary most in their plane. Empty:
    // undivided.
    std::function<ContactGrid(uint32_t a, uint32_t b)> grid{};
};

inline constexpr double max_contact_cells = 256.0; // of the overlap of two faces, along a coordinate

// The surface of a piece, counter-clockwise seen from outside.
struct PieceSurface {
    std::span<const glm::dvec3> positions;
    std::span<const Triangle> triangles;
};

// Returns the contacts, ordered by (a, b), which number the surfaces. Fails with invalid_setting on a tolerance that is
// negative or not finite, on a cell size that is not positive or makes too many cells, and with invalid_mesh on a triangle that names no position or one that is not finite.
[[nodiscard]] Result<std::vector<Bond>> find_contacts(std::span<const PieceSurface> surfaces,
                                                      const ContactSettings& settings = {});
// The contacts between the pieces of fragments, whatever their bonds and caps say.
[[nodiscard]] Result<std::vector<Bond>> find_contacts(const Fragments& fragments, const ContactSettings& settings = {});

} // namespace brittle::fracture
