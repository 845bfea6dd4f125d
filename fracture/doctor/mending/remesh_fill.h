// Refines a fill to the density of the surface around it and, on request, makes it as smooth (Liepa, "Filling holes in
// meshes", 2003).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/doctor/mending/fill_loop.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture::mending {

// The neighbours of each vertex in a mesh, over its edges.
class Neighbours {
  public:
    explicit Neighbours(const TriangleMesh& mesh);
    [[nodiscard]] std::span<const uint32_t> of(uint32_t vertex) const;

  private:
    std::vector<uint32_t> begin_, neighbours_;
};

struct Remeshed {
    std::vector<Triangle> triangles; // indices beyond the positions: into `points`, in order
    std::vector<glm::dvec3> points;
};

// Divides triangles of a fill whose middle is further from all corners than the edges at these are long (section 4.2),
// and flips edges towards Delaunay; a flip makes no edge that exists already. Smooth: then moves the new points to where
// the squares of the differences between each vertex and the mean of its neighbours have the least sum, which continues
// the curvature of the surface around (section 4.3).
[[nodiscard]] Remeshed remesh_fill(std::span<const glm::dvec3> positions, std::span<const Triangle> fill,
                                   const Neighbours& neighbours, const Taken& taken, bool smooth);

} // namespace brittle::fracture::mending
