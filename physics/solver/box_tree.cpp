#include "physics/solver/box_tree.h"

#include <algorithm>
#include <numeric>

namespace brittle::physics {

BoxTree::BoxTree(std::span<const Bounds> boxes) {
    if (boxes.empty()) return;
    nodes_.reserve(2 * boxes.size() - 1);
    std::vector<uint32_t> indices(boxes.size());
    std::iota(indices.begin(), indices.end(), 0u);
    build(boxes, indices);
}

uint32_t BoxTree::build(std::span<const Bounds> boxes, std::span<uint32_t> indices) {
    const auto own = static_cast<uint32_t>(nodes_.size());
    nodes_.push_back({.box = boxes[indices.front()], .first = indices.front()});
    if (indices.size() == 1) return own;
    for (const uint32_t index : indices) nodes_[own].box = both(nodes_[own].box, boxes[index]);
    const glm::vec3 size = nodes_[own].box.high - nodes_[own].box.low;
    const int axis = size.x < size.y ? (size.y < size.z ? 2 : 1) : (size.x < size.z ? 2 : 0);
    const size_t half = indices.size() / 2;
    std::ranges::nth_element(indices, indices.begin() + static_cast<std::ptrdiff_t>(half), [&](uint32_t a, uint32_t b) {
        const float at_a = boxes[a].low[axis] + boxes[a].high[axis], at_b = boxes[b].low[axis] + boxes[b].high[axis];
        return at_a != at_b ? at_a < at_b : a < b;
    });
    const uint32_t first = build(boxes, indices.first(half)), second = build(boxes, indices.subspan(half));
    nodes_[own].first = first;
    nodes_[own].second = second;
    return own;
}

} // namespace brittle::physics
