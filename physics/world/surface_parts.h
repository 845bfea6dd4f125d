// The collision hulls of a body that never moves: they follow its surface, with every hollow of it, instead of enclosing
// its volume. For terrain, stairs, bowls and the walls of a level.
//
// Triangles that lie in one plane and form a convex polygon are one facet. The hull of a facet is a slab under it, on the
// inner side, at most half as thick as the solid there. A mesh may be open: its slabs lie on the side that its triangles
// turn their back to.
//
//     world.add_body({.parts = surface_parts(mesh.positions, mesh.triangles, centre), .fixed = true, ...});
//
// Metres. Pure function; equal input gives equal parts.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"
#include "physics/world/world.h"

namespace brittle::physics {

// The facet of a surface that a hull lies under, in the axes of the points. Contacts press along its
// normal; over a side they turn at most to the normal of the facet there. So a body slides over the seams of a plane as
// over one face, and over ridges along the normal of the contact.
struct SurfaceFacet {
    struct Side {
        glm::vec3 outward{0.0f};          // unit, in the plane of the facet, across the side
        float cosine = 1.0f, sine = 0.0f; // of the angle to the facet beyond: 0 in a plane and in a valley
    };
    glm::vec3 normal{0.0f, 1.0f, 0.0f}; // unit
    float depth = 0.0f;                 // m, thickness of the hull
    std::vector<Side> sides{};          // of the facet that have one beyond

    // The direction nearest to a unit direction along which contacts of the facet may press.
    [[nodiscard]] glm::vec3 limit(glm::vec3 direction) const;
};

struct SurfacePartSettings {
    double max_depth = 0.25;   // m, thickness of a slab in a thick solid; a body that sinks deeper may come out below
    double min_depth = 0.004;  // m, thickness of a slab in a thin solid, which it may exceed
    double margin = 0.001;     // m, collision margin; slabs are lowered by it, so that the surface is where it looks
    uint32_t max_corners = 16; // of a facet, at least 3
};

// Offsets are relative to `origin`. Triangles without area are left out. Empty where all are.
[[nodiscard]] std::vector<BodyPart> surface_parts(std::span<const glm::dvec3> positions,
                                                  std::span<const fracture::Triangle> triangles,
                                                  const glm::dvec3& origin, const SurfacePartSettings& settings = {});

} // namespace brittle::physics
