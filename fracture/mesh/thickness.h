// The local thickness of a solid: the distance from a point of its surface to the opposite side.
//
//     const Thickness thickness(mesh);
//     const std::optional<double> metres = thickness.at(triangle, centroid);
//
// Several threads may query one object.
#pragma once

#include <optional>

#include "fracture/mesh/triangle_tree.h"

namespace brittle::fracture {

class Thickness {
  public:
    // Precondition: indices are in range. The mesh must outlive this object. Time O(n log n) for n triangles.
    explicit Thickness(const TriangleMesh& mesh);

    // Returns the distance, in metres, from a point of a triangle along the inward normal to the next triangle. Empty
    // if the triangle has no area, or if the ray hits nothing, as in an open mesh. Expected time O(log n).
    // `visits` is as in TriangleTree::first_hit().
    [[nodiscard]] std::optional<double> at(uint32_t triangle, const glm::dvec3& point,
                                           uint64_t* visits = nullptr) const;
    [[nodiscard]] glm::dvec3 inward(uint32_t triangle) const; // unit inward normal; zero for a triangle without area

  private:
    const TriangleMesh& mesh_;
    TriangleTree tree_;
};

} // namespace brittle::fracture
