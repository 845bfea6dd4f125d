// A bounding volume hierarchy of axis-aligned boxes over triangles, for proximity and ray queries.
//
//     const TriangleTree tree(mesh, triangles);
//     const std::optional<double> t = tree.first_hit(origin, direction, no_index); // origin + t * direction
//
// Several threads may query one tree.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

class TriangleTree {
  public:
    struct Node {
        glm::dvec3 min, max;
        uint32_t begin, end;                      // range of order()
        uint32_t low = no_index, high = no_index; // child nodes; no_index for a leaf
    };

    // Builds the tree over the given triangle indices. The mesh must outlive the tree. Time O(n log n), depth log n.
    TriangleTree(const TriangleMesh& mesh, std::vector<uint32_t> triangles);

    [[nodiscard]] uint32_t root() const { return root_; } // no_index if there are no triangles
    [[nodiscard]] const Node& operator[](uint32_t node) const { return nodes_[node]; }
    [[nodiscard]] const std::vector<uint32_t>& order() const { return order_; }

    // Returns the smallest positive ray parameter, in lengths of `direction`, at which the ray meets a triangle other
    // than `excluded`; empty if there is none. Evaluated in double, for measurements: a ray through an edge may miss by
    // rounding. `visits`, where given, grows by the number of nodes that the ray enters, a measure of the work.
    [[nodiscard]] std::optional<double> first_hit(const glm::dvec3& origin, const glm::dvec3& direction,
                                                  uint32_t excluded, uint64_t* visits = nullptr) const;

    // Returns the distance of a point to the nearest triangle; infinity if there are none.
    [[nodiscard]] double distance(const glm::dvec3& point) const;

  private:
    uint32_t build(uint32_t begin, uint32_t end);

    const TriangleMesh& mesh_;
    std::vector<uint32_t> order_;
    std::vector<Node> nodes_;
    uint32_t root_ = no_index;
};

// Returns the smallest positive ray parameter at which the ray meets a triangle, by testing each of them; faster than a
// tree for a few triangles.
[[nodiscard]] std::optional<double> first_hit(std::span<const glm::dvec3> positions,
                                              std::span<const Triangle> triangles, const glm::dvec3& origin,
                                              const glm::dvec3& direction);

} // namespace brittle::fracture
