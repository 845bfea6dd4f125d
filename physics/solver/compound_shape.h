// A compound: a rigid arrangement of convex hulls, in metres and body axes. Compounds may share hulls, which must not
// change.
#pragma once

#include <memory>
#include <vector>

#include "physics/solver/box_tree.h"
#include "physics/solver/hull_shape.h"
#include "physics/solver/transform.h"
#include "physics/world/hull.h"

namespace brittle::physics {

// A hull in its own axes, shared by compounds, and its source.
struct SharedHull {
    std::shared_ptr<const CollisionHull> source;
    HullShape shape;
    std::vector<HullEdge> edges; // for debug lines; filled when they are first drawn
};

class CompoundShape {
  public:
    struct Child {
        std::shared_ptr<SharedHull> hull;
        Transform frame; // of the hull in the body

        [[nodiscard]] const HullShape& shape() const { return hull->shape; }
    };

    // Precondition: at least one child.
    explicit CompoundShape(std::vector<Child> children);

    [[nodiscard]] const std::vector<Child>& children() const { return children_; }
    [[nodiscard]] const BoxTree& tree() const { return tree_; } // of the children's bounds in the body
    [[nodiscard]] const Bounds& local_bounds() const { return tree_.bounds(); }
    // The bounds of local_bounds() in a frame.
    [[nodiscard]] Bounds bounds(const Transform& frame) const { return local_bounds().in(frame); }

  private:
    std::vector<Child> children_;
    BoxTree tree_;
};

} // namespace brittle::physics
