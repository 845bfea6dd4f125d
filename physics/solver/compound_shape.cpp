#include "physics/solver/compound_shape.h"

#include <cassert>
#include <utility>

namespace brittle::physics {

CompoundShape::CompoundShape(std::vector<Child> children) : children_(std::move(children)) {
    assert(!children_.empty());
    std::vector<Bounds> boxes;
    for (const Child& child : children_) boxes.push_back(child.shape().bounds(child.frame));
    tree_ = BoxTree(boxes);
}

} // namespace brittle::physics
