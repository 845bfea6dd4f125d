// Which points lie inside a solid, for many points: rays along X, through a grid of triangles.
//
//     const InsideTest inside(mesh);
//     if (inside(p)) ...
//
// The surface's turns around the point are counted, so parts that overlap are inside and cavities are not. Whether a ray
// passes a triangle is decided so that it passes exactly one of two that share an edge; only a point within rounding of
// the surface may be called either. For sites and pictures, not for cutting.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

class InsideTest {
  public:
    // The mesh is closed and its indices are in range; it must outlive the test. O(triangles).
    explicit InsideTest(const TriangleMesh& mesh);

    [[nodiscard]] bool operator()(const glm::dvec3& point) const;

  private:
    [[nodiscard]] uint32_t bin_of(double at, int axis) const;

    const TriangleMesh& mesh_;
    Box box_;
    uint32_t bins_ = 1;                     // along Y and Z
    std::vector<uint32_t> begin_, members_; // triangles by bin
};

} // namespace brittle::fracture
