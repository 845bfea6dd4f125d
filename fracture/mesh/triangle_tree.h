// A tree of boxes around triangles, for questions about what is near or in the way.
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
    static constexpr uint32_t none = 0xffffffffu;

    struct Node {
        glm::dvec3 min, max;
        uint32_t begin, end;              // into order()
        uint32_t low = none, high = none; // nodes; none for a leaf
    };

    // Of the triangles named; the mesh must outlive the tree. O(n log n), depth log n.
    TriangleTree(const TriangleMesh& mesh, std::vector<uint32_t> triangles);

    [[nodiscard]] uint32_t root() const { return root_; } // none where there are no triangles
    [[nodiscard]] const Node& operator[](uint32_t node) const { return nodes_[node]; }
    [[nodiscard]] const std::vector<uint32_t>& order() const { return order_; }

    // The least positive distance, in lengths of the direction, at which a ray passes a triangle other than `besides`. In
    // double, for measuring: what is missed by rounding are rays through edges.
    [[nodiscard]] std::optional<double> first_hit(const glm::dvec3& origin, const glm::dvec3& direction,
                                                  uint32_t besides) const;

  private:
    uint32_t build(uint32_t begin, uint32_t end);

    const TriangleMesh& mesh_;
    std::vector<uint32_t> order_;
    std::vector<Node> nodes_;
    uint32_t root_ = none;
};

// The same for a few triangles, without a tree.
[[nodiscard]] std::optional<double> first_hit(std::span<const glm::dvec3> positions,
                                              std::span<const Triangle> triangles, const glm::dvec3& origin,
                                              const glm::dvec3& direction);

} // namespace brittle::fracture
