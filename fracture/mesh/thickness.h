// How thick a solid is: from a place on its surface straight through to the other side.
#pragma once

#include <optional>

#include "fracture/mesh/triangle_tree.h"

namespace brittle::fracture {

class Thickness {
  public:
    // Indices are in range; the mesh must outlive this. O(n log n).
    explicit Thickness(const TriangleMesh& mesh);

    // Metres along the inward normal, from a point of a triangle to the next one; nothing where the triangle has no area
    // or nothing lies behind it, as in open meshes. O(log n) in expectation.
    [[nodiscard]] std::optional<double> at(uint32_t triangle, const glm::dvec3& point) const;
    [[nodiscard]] glm::dvec3 inward(uint32_t triangle) const; // unit, or zero

  private:
    const TriangleMesh& mesh_;
    TriangleTree tree_;
};

} // namespace brittle::fracture
