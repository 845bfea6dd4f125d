// A static bounding volume hierarchy: finds the boxes that overlap a given box, or that another test accepts. Queries
// are thread-safe.
#pragma once

#include <array>
#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/solver/transform.h"

namespace brittle::physics {

class BoxTree {
  public:
    BoxTree() = default;
    // Splits at the median along the longest axis.
    explicit BoxTree(std::span<const Bounds> boxes);

    // The bounds of all boxes, of which there is at least one.
    [[nodiscard]] const Bounds& bounds() const {
        assert(!nodes_.empty());
        return nodes_.front().box;
    }

    // Calls visit(index) for each box that overlaps the given one, in a fixed but unspecified order.
    template<class Visit>
    void for_each_overlap(const Bounds& box, const Visit& visit) const {
        for_each_where([&](const Bounds& own) { return own.overlaps(box); }, visit);
    }

    // Calls visit(index) for each box that the test accepts, in the same order. The test must accept each box that
    // contains a box that it accepts. It may accept fewer boxes after a visit.
    template<class Test, class Visit>
    void for_each_where(const Test& accepts, const Visit& visit) const {
        std::array<uint32_t, 64> stack; // exceeds the depth of any tree of halves
        size_t depth = 0;
        if (!nodes_.empty()) stack[depth++] = 0;
        while (depth > 0) {
            const Node& node = nodes_[stack[--depth]];
            if (!accepts(node.box)) continue;
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
        uint32_t first = 0, second = 0; // children; of a leaf: the index of its box, and 0

        [[nodiscard]] bool leaf() const { return second == 0; } // the root is no child
    };

    uint32_t build(std::span<const Bounds> boxes, std::span<uint32_t> indices);

    std::vector<Node> nodes_; // the root first
};

} // namespace brittle::physics
