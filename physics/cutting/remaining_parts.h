// The collision hulls of what remains of a solid after a blow, from the hulls that it had.
//
// A hull that no lost cell reaches stays as it is. A plane that touches the lost cells splits the larger part off each
// other hull, as one hull with the corners that it had. What lies before the plane is divided along the Voronoi cells of
// the sites that stay; cells that a lost cell does not separate share a hull. So hulls lie inside those before, and
// outside the cells of the pieces that left; they overlap neither. Parts without any of the solid in them are dropped.
//
// Metres; coordinates of the object. Pure function; equal input gives equal parts with any number of threads.
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
    std::span<const glm::dvec3> sites{};
    std::span<const std::vector<HullPlane>> planes{}; // by site: what bounds its cell
    std::span<const uint8_t> lost{};                  // by site: 1 where the piece in its cell leaves the solid
    std::span<const std::vector<HullPlane>> more{};   // bounds of other convex regions that leave the solid
};

struct FormerParts {
    std::span<const BodyPart> parts{};
    glm::dvec3 origin{0.0}; // that they are relative to
};

// `surface` bounds what remains. Where several solids remain, each gets its parts by a call of its own:
// `is_one_of_many` leaves out those with nothing of this one in them. Hulls of less than `least` m^3 are left out. The
// result is relative to `origin`.
[[nodiscard]] std::vector<BodyPart> remaining_parts(const FormerParts& before, const fracture::ClusterMesh& surface,
                                                    bool is_one_of_many, const LostCells& cells, double least,
                                                    const glm::dvec3& origin, const HullSettings& settings = {},
                                                    uint32_t threads = 1);

} // namespace brittle::physics
