// Fills rims that lie in a plane, or that are simple when seen along their normal.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/doctor/mending/fill_loop.h"
#include "fracture/mesh/mesh.h"
#include "fracture/triangulation/triangulate.h"

namespace brittle::fracture::mending {

// Newell's normal of a loop: perpendicular to it where it lies in a plane, twice its area long.
[[nodiscard]] glm::dvec3 normal_of(std::span<const glm::dvec3> positions, const Loop& loop);

// Points in a plane with that normal, which is not zero; counter-clockwise as seen against it.
class PlaneBasis {
  public:
    PlaneBasis(const glm::dvec3& origin, const glm::dvec3& normal);
    [[nodiscard]] glm::dvec2 operator()(const glm::dvec3& p) const;

  private:
    glm::dvec3 origin_, u_, v_;
};

// Fills an outer loop, the first, and holes in it, which run the other way. Empty where they are not simple
// as seen along the outer one's normal, or where a triangle is taken. Near-linear time.
[[nodiscard]] std::vector<Triangle> fill_in_plane(std::span<const glm::dvec3> positions, std::span<const Loop> loops,
                                                  const Taken& taken);

// The edges between two of the triangles that are taken.
[[nodiscard]] uint32_t taken_inside(const std::vector<Triangle>& triangles, const Taken& taken);

// Loops that lie in one plane, as lists of indices: an outer one, then those directly inside of it that run
// the other way; the ends of a pipe, say. Only lists of two and more.
[[nodiscard]] std::vector<std::vector<uint32_t>> find_rings(std::span<const glm::dvec3> positions,
                                                            std::span<const Loop> loops);

} // namespace brittle::fracture::mending
