// Bricks of a wall, and which of them a blow takes out.
//
// In running bond: bricks end to end along X, courses of them along Y, each course and each layer along Z begins half a brick
// farther on; or end to end along Y or Z, and courses and layers along the others. A brick is the Voronoi cells of its two
// halves' middles; these make a lattice, so its faces are bisectors.
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
    glm::dvec3 brick{0.25, 0.075, 0.12}; // size with joints
    glm::dvec3 corner{0.0};              // of some brick
    uint32_t along = 0;                  // axis: end to end
};

// Whole bricks that fill the box, of nearly the size that they had.
[[nodiscard]] RunningBond fitted(const RunningBond& bond, const fracture::Box& box);

struct BricksTaken {
    std::vector<std::array<glm::dvec3, 2>> bricks; // the middles of their halves; the nearest first
    std::vector<glm::dvec3> beside;                // of halves that are next to those and stay
    double diagonal = 0.0; // m, of a half: sites that are farther than that from a half's middle take nothing of it
};

// Those of a box of which a half's middle is within radius of the point and, by `there`, has not gone before; the nearest
// ones if there are more than most. None where the box has no two bricks, or bricks no size or axis.
[[nodiscard]] BricksTaken bricks_near(const RunningBond& bond, const fracture::Box& box, const glm::dvec3& point,
                                      double radius, uint32_t most,
                                      const std::function<bool(const glm::dvec3&)>& there);

} // namespace brittle::physics
