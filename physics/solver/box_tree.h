// A static tree of bounds: the boxes of many that overlap one. Not thread-safe to build; queries are.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/solver/transform.h"

namespace brittle::physics {

class BoxTree {
  public:
    BoxTree() = default;
    // By halving at the median of the longest axis.
    explicit BoxTree(std::span<const Bounds> boxes);

    // The bounds of all boxes.
    [[nodiscard]] const Bounds& bounds() const { return nodes_.front().box; }

    // Calls visit(index) for each box that overlaps the given one, in no particular but a fixed order.
    template<class Visit>
    void for_each_overlap(const Bounds& box, const Visit& visit) const {
        std::array<uint32_t, 64> stack; // deeper than any tree that is halved
        size_t depth = 0;
        if (!nodes_.empty()) stack[depth++] = 0;
        while (depth > 0) {
            const Node& node = nodes_[stack[--depth]];
            if (!node.box.overlaps(box)) continue;
            if (node.leaf()) {
                visit(node.first);
            } else {
                stack[depth++] = node.second;
                stack[depth++] = node.first;
            }
        }
    }

  private:
    struct Node {
        Bounds box;
        uint32_t first = 0, second = 0; // children; of a leaf: the index of its box, and none

        [[nodiscard]] bool leaf() const { return second == 0; } // the root is nobody's child
    };

    uint32_t build(std::span<const Bounds> boxes, std::span<uint32_t> indices);

    std::vector<Node> nodes_; // the root first
};

} // namespace brittle::physics
