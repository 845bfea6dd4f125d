// Mass properties of a closed, oriented triangle mesh at density 1, by the divergence (Gauss) theorem.
//
// "Real Time Voronoi Fracturing of Polygon Meshes", eq. 5 (signed volume) and eq. 6 (area). Centre of mass and inertia
// come from the same sum over signed tetrahedra. The integrals are exact for polyhedra, up to rounding. They are taken
// about the centre of the mesh's box, so that a mesh far from the origin loses no digits.
//
//     const MassProperties mass = mass_properties(mesh.positions, mesh.triangles);
//     const double kilograms = density * mass.volume;
//
// All functions are reentrant.
#pragma once

#include <span>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

struct MassProperties {
    double volume = 0.0;            // m^3; negative for an inside-out mesh
    double area = 0.0;              // m^2, sum over all triangles
    glm::dvec3 centre_of_mass{0.0}; // m; the mean of the triangles' corners if the volume is zero up to rounding
    glm::dmat3 inertia{0.0};        // m^5, about the centre of mass, in world axes; multiply by the density for kg m^2
};

// Returns the mass properties of the triangles, whose indices refer to `positions`. Time is linear, nothing is
// allocated. An empty mesh gives zeros. A volume that is zero up to rounding gives zero inertia. An inside-out mesh
// gives negative volume and negated inertia. For an open mesh only the area is meaningful; the other figures depend on
// the mesh's place.
[[nodiscard]] MassProperties mass_properties(std::span<const glm::dvec3> positions,
                                             std::span<const Triangle> triangles);

// As above, bit for bit, at three quarters of the cost. `box` bounds the corners of the triangles: bounds(positions) where
// triangles use every position.
[[nodiscard]] MassProperties mass_properties(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
                                             const Box& box);

// Returns the volume alone (eq. 5), bit for bit equal to mass_properties().volume, at about half the cost.
[[nodiscard]] double signed_volume(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles);

// Returns the mass properties of a closed mesh of positive volume after some of its triangles were exchanged for others
// with the same border. Time is linear in the triangles exchanged. The area of what is left alone keeps its rounding.
[[nodiscard]] MassProperties exchange_triangles(const MassProperties& before,
                                                std::span<const glm::dvec3> removed_positions,
                                                std::span<const Triangle> removed,
                                                std::span<const glm::dvec3> added_positions,
                                                std::span<const Triangle> added);

// Returns a bound on the rounding error of signed_volume(), for exact positions.
[[nodiscard]] double volume_error_bound(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles);

} // namespace brittle::fracture
