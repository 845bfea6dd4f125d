// A joint of World on stock Bullet: its point-to-point, hinge and fixed constraints, and a distance constraint of our
// own, since Bullet has none with one row.
//
// Lengths are in Bullet's unit here (bullet_engine.cpp). Holders of a joint hold Bullet's mutex.
#pragma once

#include <btBulletDynamicsCommon.h>

namespace brittle::physics {

// The side of a fixed constraint: an axis and a direction across it, both of unit length.
inline btTransform joint_frame(const btVector3& anchor, const btVector3& axis, const btVector3& up) {
    const btVector3 side = axis.cross(up);
    const btMatrix3x3 basis(axis.x(), up.x(), side.x(), axis.y(), up.y(), side.y(), axis.z(), up.z(), side.z());
    return btTransform(basis, anchor);
}

// Keeps the distance of two points between two lengths.
class BulletDistance final : public btTypedConstraint {
  public:
    BulletDistance(btRigidBody& a, btRigidBody& b, const btVector3& in_a, const btVector3& in_b, float low, float high)
        : btTypedConstraint(MAX_CONSTRAINT_TYPE, a, b), in_a_(in_a), in_b_(in_b), low_(low), high_(high) {}

    void getInfo1(btConstraintInfo1* info) override {
        info->m_numConstraintRows = 1;
        info->nub = 5;
    }
    // Bullet solves J v = error: the row closes within the step what is open, and a part of what is too long or short.
    void getInfo2(btConstraintInfo2* info) override {
        const btTransform &a = m_rbA.getCenterOfMassTransform(), &b = m_rbB.getCenterOfMassTransform();
        const btVector3 arm_a = a.getBasis() * in_a_, arm_b = b.getBasis() * in_b_;
        const btVector3 apart = a.getOrigin() + arm_a - b.getOrigin() - arm_b;
        const btScalar length = apart.length();
        const btVector3 n = length > SIMD_EPSILON ? apart / length : btVector3(0, 1, 0);
        const btVector3 rotation_a = arm_a.cross(n), rotation_b = -arm_b.cross(n);
        for (int axis = 0; axis < 3; ++axis) {
            info->m_J1linearAxis[axis] = n[axis];
            info->m_J2linearAxis[axis] = -n[axis];
            info->m_J1angularAxis[axis] = rotation_a[axis];
            info->m_J2angularAxis[axis] = rotation_b[axis];
        }
        const bool upper = length - low_ > high_ - length;
        const btScalar open = (upper ? high_ : low_) - length; // of the upper bound: how far it may still part
        const bool reached = upper ? open <= 0 : open >= 0;
        info->m_constraintError[0] = open * info->fps * (reached ? info->erp : btScalar(1));
        info->m_lowerLimit[0] = low_ == high_ || upper ? -SIMD_INFINITY : 0;
        info->m_upperLimit[0] = low_ == high_ || !upper ? SIMD_INFINITY : 0;
    }
    void setParam(int, btScalar, int) override {}
    [[nodiscard]] btScalar getParam(int, int) const override { return 0; }

  private:
    btVector3 in_a_, in_b_; // the anchors, in the frames of the bodies
    btScalar low_, high_;
};

} // namespace brittle::physics
