// What a piece's corners inherit: where they lie on the input's triangles, and texture coordinates for the cuts.
//
// Exterior triangles are parts of input triangles (Fragments::triangle_source): normals, colours, texture coordinates
// and materials of the input carry over by weighting those of its corners.
//
//     const auto weights = barycentrics(mesh, fragments, piece, t);
//     for (int k = 0; k < 3; ++k) uv[k] = weights[k].x * uv_of_corner[0] + weights[k].y * ... + weights[k].z * ...;
//
// Interior triangles have no material in the input: give them one of their own, after the input's last. Their texture
// coordinates are in metres, so a texture has the same grain on every piece.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture {

// Of each corner of an exterior triangle, its weights in the source triangle, for that triangle's corners x, y, z: none
// negative, of sum 1. Exactly a unit vector at a vertex of the input, exactly zero for the corner opposite a side that
// the point lies on up to rounding. In a source triangle without area, weights along its longest side. `triangle`
// indexes Fragments::triangles and is one of the piece's.
[[nodiscard]] std::array<glm::dvec3, 3> barycentrics(const TriangleMesh& source, const Fragments& fragments,
                                                     const Piece& piece, uint32_t triangle);

// Texture coordinates of the corners of an interior triangle, metres: planar, by the plane of the cut, from the middle
// between the two sites. u is level (along Z where the cut is), v goes up. Both sides of a cut have the same, so
// one of them sees the texture mirrored. `sites` are those of the fracture.
[[nodiscard]] std::array<glm::dvec2, 3> interior_uv(std::span<const glm::dvec3> sites, const Fragments& fragments,
                                                    const Piece& piece, uint32_t triangle);

// Likewise of a point on a cut, by the cut's unit normal alone, from the origin.
[[nodiscard]] glm::dvec2 plane_uv(const glm::dvec3& normal, const glm::dvec3& point);

} // namespace brittle::fracture
