// Finds pairs of triangles whose boxes meet, on several threads.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <glm/vec2.hpp>

#include "fracture/base/threads.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture::arrangement {

// A box in floats, rounded outwards.
struct FloatBox {
    std::array<float, 3> low, high;

    [[nodiscard]] bool meets(const FloatBox& other) const {
        return low[0] <= other.high[0] && other.low[0] <= high[0] && low[1] <= other.high[1] && other.low[1] <= high[1]
               && low[2] <= other.high[2] && other.low[2] <= high[2];
    }
};

[[nodiscard]] FloatBox float_box(const glm::dvec3& low, const glm::dvec3& high);

// A hierarchy of boxes: triangles in the order of a space-filling curve, in blocks of eight, and a binary tree over the
// blocks.
class BoxTree {
  public:
    BoxTree(const TriangleMesh& mesh, std::span<const uint32_t> triangles, Threads& threads);

    // Returns the pairs whose boxes meet and that pass a test, as (lower, higher) triangle in ascending order.
    // `may_meet(s, t)` is called by several threads.
    [[nodiscard]] std::vector<glm::uvec2> pairs(const std::function<bool(uint32_t, uint32_t)>& may_meet,
                                                Threads& threads) const;
    // The same for a triangle of this tree and one of another tree.
    [[nodiscard]] std::vector<glm::uvec2>
    pairs(const BoxTree& other, const std::function<bool(uint32_t, uint32_t)>& may_meet, Threads& threads) const;

    // Calls visit(t) for the triangles whose boxes meet a box.
    template<class Visit>
    void for_meeting(const FloatBox& box, Visit&& visit) const {
        if (!triangles_.empty()) descend(box, 1, visit);
    }

  private:
    static constexpr uint32_t block = 8;
    struct Search;

    // Node 1 is the root, the children of node n are 2 n and 2 n + 1, and the last level holds the blocks.
    template<class Visit>
    void descend(const FloatBox& box, uint32_t node, Visit& visit) const {
        if (!nodes_[node].meets(box)) return;
        if (node < leaves_) {
            descend(box, 2 * node, visit);
            descend(box, 2 * node + 1, visit);
            return;
        }
        for (uint32_t k = first(node); k < last(node); ++k)
            if (boxes_[k].meets(box)) visit(triangles_[k]);
    }

    [[nodiscard]] uint32_t first(uint32_t leaf) const { return (leaf - leaves_) * block; }
    [[nodiscard]] uint32_t last(uint32_t leaf) const {
        return std::min(first(leaf) + block, static_cast<uint32_t>(triangles_.size()));
    }

    std::vector<uint32_t> triangles_; // in order
    std::vector<FloatBox> boxes_;     // of the triangles
    std::vector<FloatBox> nodes_;
    uint32_t leaves_ = 1; // a power of two
};

} // namespace brittle::fracture::arrangement
