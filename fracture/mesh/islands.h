// Connected parts of a cut mesh: the legs of an animal below a plane are four pieces, not one.
//
// Parts are shells that share no vertex. A shell of negative volume is a cavity: it belongs to the smallest
// island around it, so a hollow sphere in one cell stays one piece with its cavity.
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
    std::vector<Triangle> triangles; // exterior ones first, otherwise in the order of the input
    std::vector<FaceSource> sources; // per triangle
    uint32_t exterior_triangles = 0;
    MassProperties mass;
};

// Splits a closed mesh. Islands come in the order of their first triangle. An inward shell that no island
// contains is an island of negative volume. Islands without volume (see flat_island in islands.cpp) are left
// out: a plane that runs along a face of the solid can leave a sheet of no thickness on its other side.
[[nodiscard]] std::vector<Island> split_islands(std::span<const glm::dvec3> positions,
                                                std::span<const Triangle> triangles,
                                                std::span<const FaceSource> sources, double extent = 0.0);

// Whether a closed mesh has no volume but rounding (see flat_island in islands.cpp). `extent` is the largest coordinate
// of the solid that it was cut from: positions carry its rounding.
[[nodiscard]] bool is_flat(const MassProperties& mass, std::span<const glm::dvec3> positions, double extent);

// How often a closed mesh winds around a point: 1 inside, 0 outside, by the sum of the signed solid angles of
// its triangles (van Oosterom and Strackee 1983). In double; between for a point on the surface.
[[nodiscard]] double winding_number(const glm::dvec3& point, std::span<const glm::dvec3> positions,
                                    std::span<const Triangle> triangles);

// Whether a closed shell lies inside a closed mesh. The two may touch, as where a plane runs along a face of a cavity,
// but do not cross.
[[nodiscard]] bool encloses(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
                            std::span<const glm::dvec3> shell_positions, std::span<const Triangle> shell);

} // namespace brittle::fracture
