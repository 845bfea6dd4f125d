// Bullet's convex hull with what a heap asks of it thousands of times a step done four points at a time: how far it
// reaches in a direction, and its box.
//
// The box is that of the points where they are, not, as Bullet's, that of a turned box: in a heap of pieces half as many pairs
// of boxes overlap. Bullet's box of the shape in its own axes is not kept. Reserve, add all points, set the margin, then call
// finish() once. Bullet's units.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include "physics/solver/float4.h"

namespace brittle::physics {

class HullShape final : public btConvexHullShape {
  public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    // Bullet's array of points grows by doubling.
    void reserve(size_t points) { m_unscaledPoints.reserve(static_cast<int>(points)); }
    // As addPoint() without a new box, but here.
    void add(const btVector3& point) { m_unscaledPoints.push_back(point); }
    void finish();

    // The points by groups of four, each four x, four y, four z; the last point fills up.
    static constexpr size_t group_size = 12;
    [[nodiscard]] std::span<const btScalar> groups() const { return lanes_; }
    // How far the four of a group reach in a direction.
    static Float4 along(const btScalar* group, const btVector3& direction) {
        return Float4::load(group) * Float4::all(direction.x()) + Float4::load(group + 4) * Float4::all(direction.y())
               + Float4::load(group + 8) * Float4::all(direction.z());
    }

    void getAabb(const btTransform& frame, btVector3& low, btVector3& high) const override;

    // The farthest that the points, without margin, reach in a direction of the shape's own axes.
    [[nodiscard]] btScalar reach(const btVector3& direction) const;
    // The point that reaches farthest, the first of several.
    [[nodiscard]] int farthest(const btVector3& direction) const;
    // Radius of the ball around the shape's origin that holds it, margin included.
    [[nodiscard]] btScalar radius() const { return radius_; }
    // The longest side of the box in the shape's own axes.
    [[nodiscard]] btScalar longest() const { return longest_; }
    // Bullet finds it from the box each time it is asked.
    [[nodiscard]] btScalar getAngularMotionDisc() const override { return motion_disc_; }

  private:
    std::vector<btScalar> lanes_; // groups()
    btScalar radius_ = 0.0f, longest_ = 0.0f, motion_disc_ = 0.0f;
};

} // namespace brittle::physics
