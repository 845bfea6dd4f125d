// The collision shape of a solid that is not convex: the hulls of its parts, cut along Voronoi cells.
//
// A part whose hull is too empty is cut in two by the bisector of two sites that are far apart in it, and what falls apart
// there separates, until all hulls are full enough or there are enough of them. Parts of one cell stay in that cell,
// which is convex, so hulls of different parts overlap only where the islands of one cell do, and the hulls of the parts of
// a Voronoi cell do not leave it.
//
// After Mueller, Chentanez and Kim, "Real Time Dynamic Fracture with Volumetric Approximate Convex Decompositions",
// SIGGRAPH 2013, section 3; cells of a few sites here instead of the merging of many.
//
//     std::vector<BodyPart> parts = convex_parts(positions, triangles, volume, centre_of_mass);
//     world.add_body({.parts = parts, ...});
//
// Metres. Pure functions; equal input gives equal parts. Any closed mesh has a result, of at least one part.
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
    double max_empty = 0.2;    // share of a hull's volume that the solid need not fill
    double min_excess = 0.003; // of the solid's volume; emptier space than that in a hull is not looked at
    uint32_t max_parts = 24;   // at least 1
    HullSettings hull{};
};

// Offsets and hulls are relative to origin, as BodyDesc::parts wants them where that is the centre of mass.
[[nodiscard]] std::vector<BodyPart> convex_parts(std::span<const glm::dvec3> positions,
                                                 std::span<const fracture::Triangle> triangles, double volume,
                                                 const glm::dvec3& origin, const ConvexPartSettings& settings = {});

// Of many points those that make nearly the same hull: in each of 600 directions around their middle the one
// farthest out. Few points are all kept.
[[nodiscard]] std::vector<glm::dvec3> hull_candidates(std::span<const glm::dvec3> points);

} // namespace brittle::physics
