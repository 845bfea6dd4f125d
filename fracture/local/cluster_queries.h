// Questions about places in and around the solid that a ClusterMesh bounds. The cost grows with the clusters near the
// place, not with the mesh.
//
// Evaluated in double: points within rounding of the surface may get either answer. Thread-safe.
#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "fracture/local/cluster_mesh.h"

namespace brittle::fracture {

// The winding number of a set of triangles around a point: how often a ray from there along +X leaves the set by a
// front side, less how often it enters by one. Of two triangles with a common edge, a ray through the edge meets
// exactly one.
class RayWinding {
  public:
    explicit RayWinding(const glm::dvec3& from) : from_(from) {}
    void add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);
    [[nodiscard]] int winding() const { return winding_; }
    // The part of the ray in a box, which need not hold its origin.
    [[nodiscard]] Box reach(const Box& box) const { return {from_, {box.max.x, from_.y, from_.z}}; }

  private:
    glm::dvec3 from_;
    int winding_ = 0;
};

// Returns whether the surface winds around the point.
[[nodiscard]] bool is_inside(const ClusterMesh& mesh, const glm::dvec3& point);

// Returns the first point at which a segment meets the surface, as a share of the way from `from` to `to`; empty if
// there is none.
[[nodiscard]] std::optional<double> first_hit(const ClusterMesh& mesh, const glm::dvec3& from, const glm::dvec3& to);

// Returns the largest coordinate along a direction, and the largest distance from a point, of the surface's vertices. 0
// for an empty mesh.
[[nodiscard]] double farthest_along(const ClusterMesh& mesh, const glm::dvec3& from, const glm::dvec3& direction);
[[nodiscard]] double farthest_from(const ClusterMesh& mesh, const glm::dvec3& point);

// Returns the point of the surface that is nearest to `point`, which is itself for an empty mesh.
[[nodiscard]] glm::dvec3 nearest_on(const ClusterMesh& mesh, const glm::dvec3& point);

} // namespace brittle::fracture
