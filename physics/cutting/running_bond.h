// Bricks of a wall in running bond, and the bricks that a blow knocks out.
//
// Bricks lie end to end along one axis (`along`, X by default). Courses are stacked along Y and layers along Z; each
// course and each layer starts half a brick further on. With `along` Y or Z, courses and layers run along the other two
// axes. A brick is the union of the Voronoi cells of its two halves' middles. These middles form a lattice, so every
// face of a brick is a bisector.
//
// Coordinates of the solid, metres. Pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::physics {

struct RunningBond {
    glm::dvec3 brick{0.25, 0.075, 0.12}; // m, size with joints
    glm::dvec3 corner{0.0};              // m, a corner of any brick
    uint32_t along = 0;                  // axis along which bricks lie end to end
};

// The bond with the nearest brick size for which whole bricks fill the box.
[[nodiscard]] RunningBond fitted(const RunningBond& bond, const fracture::Box& box);

struct BricksTaken {
    std::vector<std::array<glm::dvec3, 2>> bricks; // middles of the two halves of each brick, the nearest brick first
    std::vector<glm::dvec3> beside;                // middles of the halves next to them, which stay
    double diagonal = 0.0; // m, of half a brick: a site farther than this from a half's middle takes none of that half
};

// The bricks of a box with a half whose middle lies within `radius` of the point and is still solid (`there`): the
// nearest `most` of them. None where the box holds fewer than two bricks, or the bond has an invalid size or axis.
[[nodiscard]] BricksTaken bricks_near(const RunningBond& bond, const fracture::Box& box, const glm::dvec3& point,
                                      double radius, uint32_t most,
                                      const std::function<bool(const glm::dvec3&)>& there);

} // namespace brittle::physics
