// Fills rims that lie in a plane, or that are simple in projection along their normal.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/doctor/mending/fill_loop.h"
#include "fracture/mesh/mesh.h"
#include "fracture/triangulation/triangulate.h"

namespace brittle::fracture::mending {

// Newell's normal of a loop: perpendicular to its plane, with twice its area as length.
[[nodiscard]] glm::dvec3 normal_of(std::span<const glm::dvec3> positions, const Loop& loop);

// Maps points to coordinates in a plane with the given normal, which is not zero. A loop that is counter-clockwise as
// seen against the normal stays counter-clockwise.
class PlaneBasis {
  public:
    PlaneBasis(const glm::dvec3& origin, const glm::dvec3& normal);
    [[nodiscard]] glm::dvec2 operator()(const glm::dvec3& p) const;

  private:
    glm::dvec3 origin_, u_, v_;
};

// Fills an outer loop, the first one, and its holes, which run in the opposite direction. Returns nothing where the
// loops are not simple in projection along the normal of the outer one, or where a triangle exists already. Near-linear
// time.
[[nodiscard]] std::vector<Triangle> fill_in_plane(std::span<const glm::dvec3> positions, std::span<const Loop> loops,
                                                  const Taken& taken);

// The number of edges between two of the triangles that exist already.
[[nodiscard]] uint32_t taken_inside(const std::vector<Triangle>& triangles, const Taken& taken);

// Finds loops that lie in one plane (the two rims of a pipe's end, for example). Each list has the index of an outer
// loop, then those of the loops directly inside it with the opposite direction. Only lists of two and more are
// returned.
[[nodiscard]] std::vector<std::vector<uint32_t>> find_rings(std::span<const glm::dvec3> positions,
                                                            std::span<const Loop> loops);

} // namespace brittle::fracture::mending
