// Connected components (islands) of a cut mesh: the legs of an animal below a plane are four pieces, not one.
//
// Islands are shells that share no vertex. A shell of negative volume is a cavity and belongs to the smallest island
// around it: a hollow sphere in one cell remains one piece with its cavity.
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/half_edge.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

struct Island {
    std::vector<glm::dvec3> positions;
    std::vector<Triangle> triangles; // exterior triangles first, otherwise in input order
    std::vector<FaceSource> sources; // per triangle
    uint32_t exterior_triangles = 0;
    MassProperties mass;
};

// Splits a closed mesh into islands, ordered by first triangle. A cavity that no island contains becomes an island of
// negative volume. Islands without volume are dropped (flat_island in islands.cpp): a plane that runs along a face of
// the solid can leave a sheet of zero thickness on its other side. `extent` is as in is_flat().
[[nodiscard]] std::vector<Island> split_islands(std::span<const glm::dvec3> positions,
                                                std::span<const Triangle> triangles,
                                                std::span<const FaceSource> sources, double extent = 0.0);

// Returns whether the volume of a closed mesh is zero up to rounding of its own positions and integral (flat_island in
// islands.cpp). `extent` is the largest coordinate of the solid from which the mesh was cut, because the positions of
// cut points carry rounding errors of that magnitude; 0 for a mesh that no plane has cut.
[[nodiscard]] bool is_flat(const MassProperties& mass, std::span<const glm::dvec3> positions,
                           std::span<const Triangle> triangles, double extent);

// Returns the winding number of a closed mesh around a point: 1 inside, 0 outside, an intermediate value on the
// surface. Evaluated in double, as the sum of the signed solid angles of the triangles (van Oosterom and Strackee
// 1983).
[[nodiscard]] double winding_number(const glm::dvec3& point, std::span<const glm::dvec3> positions,
                                    std::span<const Triangle> triangles);

// Returns whether a closed shell lies inside a closed mesh. The two may touch, as where a plane runs along a face of a
// cavity, but must not cross.
[[nodiscard]] bool encloses(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
                            std::span<const glm::dvec3> shell_positions, std::span<const Triangle> shell);

} // namespace brittle::fracture
