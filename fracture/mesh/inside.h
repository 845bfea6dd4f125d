// Point-in-solid tests for many points: counts crossings of a ray along X, through a grid of triangles.
//
//     const InsideTest inside(mesh);
//     if (inside(p)) ...
//
// The test computes the winding number of the surface around the point: overlapping parts are inside, cavities are
// outside. Of two triangles that share an edge, a ray through the edge crosses exactly one. Only points within rounding
// of the surface may get either answer, so the test serves sites and pictures, not cutting. Several threads may use one
// test.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

class InsideTest {
  public:
    // Precondition: the mesh is closed and its indices are in range. The mesh must outlive the test. Time and memory
    // are linear in the number of triangles, if these are of similar size.
    explicit InsideTest(const TriangleMesh& mesh);

    [[nodiscard]] bool operator()(const glm::dvec3& point) const;

  private:
    [[nodiscard]] uint32_t bin_of(double at, int axis) const;

    const TriangleMesh& mesh_;
    Box box_;
    uint32_t bins_ = 1;                     // bins along each of Y and Z
    std::vector<uint32_t> begin_, members_; // triangles of each bin
};

} // namespace brittle::fracture
