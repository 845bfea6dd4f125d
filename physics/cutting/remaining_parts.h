// The collision hulls of what remains of a solid after a blow, from the hulls that it had.
//
// A hull that no lost cell reaches stays as it is. Each other one is cut along the Voronoi cells of the sites: what lies
// in the cell of a site that stays becomes a hull of its own. So hulls lie inside those before, and outside the cells of
// the pieces that left; they overlap neither. Parts without any of the solid in them are dropped.
//
// Metres; coordinates of the object. Pure function, equal input gives equal parts.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/local/cluster_mesh.h"
#include "physics/world/hull.h"
#include "physics/world/world.h"

namespace brittle::physics {

struct LostCells {
    std::span<const std::vector<HullPlane>> planes{}; // by site: what bounds its cell
    std::span<const uint8_t> lost{};                  // by site: 1 where the piece in its cell leaves the solid
};

// `before` are hulls relative to `origin_before`, `surface` is the solid that they belong to; the result is relative to
// `origin`. Hulls of less than `least` m^3 are dropped.
[[nodiscard]] std::vector<BodyPart> remaining_parts(std::span<const BodyPart> before, const glm::dvec3& origin_before,
                                                    const fracture::ClusterMesh& surface, const LostCells& cells,
                                                    double least, const glm::dvec3& origin,
                                                    const HullSettings& settings = {});

} // namespace brittle::physics
