// Approximate convex decomposition: the collision hulls of a solid that is not convex.
//
// Start with the hull of the solid. While a hull is too empty, cut its part in two along the bisector of two sites that
// are far apart in it; islands of a half become parts of their own. Every part lies in the Voronoi cell of its cuts,
// and that cell is convex. So hulls of different parts overlap only where they belong to islands of one cell, and the
// hulls of a Voronoi cell's parts stay inside that cell.
//
// After Mueller, Chentanez and Kim, "Real Time Dynamic Fracture with Volumetric Approximate Convex Decompositions",
// SIGGRAPH 2013, section 3. Deviation: cells of a few sites instead of merging the cells of many.
//
//     std::vector<BodyPart> parts = convex_parts(positions, triangles, volume, centre_of_mass);
//     world.add_body({.parts = parts, ...});
//
// Metres. Pure functions; equal input gives equal parts. Every closed mesh has at least one part.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"
#include "physics/world/hull.h"
#include "physics/world/world.h"

namespace brittle::physics {

struct ConvexPartSettings {
    double max_empty = 0.2;    // accepted empty share of a hull's volume
    double min_excess = 0.003; // accepted empty volume of a hull, as a share of the solid's volume
    uint32_t max_parts = 24;   // at least 1
    // The points that the hull of the whole solid holds; empty: all vertices. The caller keeps them.
    std::span<const glm::dvec3> points{};
    HullSettings hull{};
};

// Offsets and hulls are relative to `origin`; BodyDesc::parts takes them relative to the centre of mass. `volume` is
// the solid's.
[[nodiscard]] std::vector<BodyPart> convex_parts(std::span<const glm::dvec3> positions,
                                                 std::span<const fracture::Triangle> triangles, double volume,
                                                 const glm::dvec3& origin, const ConvexPartSettings& settings = {});

// Points with nearly the same hull: the farthest point in each of 600 bins of directions around the middle of their
// box. Up to 500 points are all kept.
[[nodiscard]] std::vector<glm::dvec3> hull_candidates(std::span<const glm::dvec3> points);

} // namespace brittle::physics
