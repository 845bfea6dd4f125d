// Attributes of piece corners: barycentric coordinates in the input's triangles, and texture coordinates for the cuts.
//
// Exterior triangles are parts of input triangles (Fragments::triangle_source). Normals, colours, texture coordinates
// and materials of the input carry over: an attribute of a corner is the sum of the source corners' attributes,
// weighted by the barycentric coordinates.
//
//     const auto weights = barycentrics(mesh, fragments, piece, t);
//     for (int k = 0; k < 3; ++k) uv[k] = weights[k].x * uv_of_corner[0] + weights[k].y * ... + weights[k].z * ...;
//
// Interior triangles have no material in the input. Give them a material of their own, after the last one of the input.
// Their texture coordinates are in metres, so a texture has equal scale on every piece. All functions are reentrant.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture {

// Returns, for each corner of an exterior triangle, its barycentric coordinates with respect to the corners x, y, z of
// the source triangle: non-negative, with sum 1. A vertex of the input gives exactly a unit vector. A point on a side,
// up to rounding, gives exactly zero for the opposite corner. A source triangle without area gives coordinates along
// its longest side. `triangle` indexes Fragments::triangles and belongs to `piece`.
[[nodiscard]] std::array<glm::dvec3, 3> barycentrics(const TriangleMesh& source, const Fragments& fragments,
                                                     const Piece& piece, uint32_t triangle);

// Returns the barycentric coordinates of one point in the same way. The corners are those of the source triangle.
[[nodiscard]] glm::dvec3 barycentrics(const std::array<glm::dvec3, 3>& corners, const glm::dvec3& point);

// Returns texture coordinates for the corners of an interior triangle, in metres: planar coordinates in the plane of
// the cut, relative to the midpoint of the two sites. u is horizontal, v points upwards; on a horizontal cut, u is
// along Z. Both sides of a cut have equal coordinates, so one of them shows the texture mirrored. `sites` are those of
// the fracture.
[[nodiscard]] std::array<glm::dvec2, 3> interior_uv(std::span<const glm::dvec3> sites, const Fragments& fragments,
                                                    const Piece& piece, uint32_t triangle);

// Returns planar texture coordinates, in metres, of a point on a plane with the given unit normal, relative to the
// origin. Opposite normals give equal coordinates.
[[nodiscard]] glm::dvec2 plane_uv(const glm::dvec3& normal, const glm::dvec3& point);

} // namespace brittle::fracture
