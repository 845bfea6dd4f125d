// A rigid arrangement of convex hulls. Hulls may be shared by compounds; they must not change. Metres, in the body's
// axes.
#pragma once

#include <memory>
#include <vector>

#include "physics/solver/box_tree.h"
#include "physics/solver/hull_shape.h"
#include "physics/solver/transform.h"
#include "physics/world/hull.h"

namespace brittle::physics {

// A hull that compounds share, in its own axes, and the hull that it was made of.
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

    // At least one child.
    explicit CompoundShape(std::vector<Child> children);

    [[nodiscard]] const std::vector<Child>& children() const { return children_; }
    [[nodiscard]] const BoxTree& tree() const { return tree_; } // of the children's bounds in the body
    [[nodiscard]] const Bounds& local_bounds() const { return tree_.bounds(); }
    // Holds the rotated local_bounds().
    [[nodiscard]] Bounds bounds(const Transform& frame) const { return local_bounds().in(frame); }

  private:
    std::vector<Child> children_;
    BoxTree tree_;
};

} // namespace brittle::physics
