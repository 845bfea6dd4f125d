#include "physics/bullet/body_record.h"

#include <algorithm>
#include <utility>

namespace brittle::physics {

namespace {

// The ball that is swept for a continuous body, as a part of the largest around the centre that fits into its
// box: small enough not to touch what the body slides along.
constexpr float swept_part = 0.8f;

// From the centre of mass to the nearest side of the shape's box, in Bullet's units.
float least_extent(const btCollisionShape& shape) {
    btVector3 low, high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    return std::min({-low.x(), -low.y(), -low.z(), high.x(), high.y(), high.z()});
}

} // namespace

// Bullet's frame has the principal axes, so the hull is turned into them.
void make_single(BodyRecord& body, const CollisionHull& hull, const glm::vec3& offset) {
    body.shape = std::make_unique<HullShape>();
    const glm::quat from_body = glm::conjugate(body.to_principal);
    for (const glm::vec3& point : hull.points)
        body.shape->addPoint(metres_to_bullet(from_body * (point + offset)), false);
    body.shape->setMargin(hull.margin * bullet_units);
    body.shape->finish();
}

void BodyRecord::start_step() {
    was_repaired = std::exchange(repaired, false) && awake();
    if (was_repaired) {
        const btTransform& frame = rigid->getWorldTransform();
        rigid->setCenterOfMassTransform(
            btTransform(repair.getRotation() * frame.getRotation(), frame.getOrigin() + repair.getOrigin()));
    }
    stepped_from = rigid->getWorldTransform();
}

float swept_radius(const btCollisionShape& shape) {
    return swept_part * least_extent(shape);
}

float longest_extent(const btCollisionShape& shape) {
    btVector3 low, high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    const btVector3 size = high - low;
    return size[size.maxAxis()];
}

int group_of(bool fixed, bool debris) {
    return fixed    ? btBroadphaseProxy::StaticFilter
           : debris ? btBroadphaseProxy::DebrisFilter
                    : btBroadphaseProxy::DefaultFilter;
}

int partners_of(bool fixed, bool debris) {
    return fixed || debris ? btBroadphaseProxy::AllFilter ^ group_of(fixed, debris)
                           : static_cast<int>(btBroadphaseProxy::AllFilter);
}

Mechanics mechanics_of(const BodyRecord& body, const glm::vec3& gravity) {
    if (body.fixed) return {};
    const btRigidBody& rigid = *body.rigid;
    const double mass = 1.0 / static_cast<double>(rigid.getInvMass());
    const glm::dvec3 position(metres_from_bullet(rigid.getCenterOfMassPosition()));
    const glm::dvec3 velocity(metres_from_bullet(rigid.getLinearVelocity()));
    const glm::dvec3 spin(to_glm(rigid.getAngularVelocity()));
    const glm::dquat orientation = glm::normalize(glm::dquat(to_glm(rigid.getOrientation())));
    const glm::dvec3 own = orientation * (body.moments * (glm::conjugate(orientation) * spin));
    return {.kinetic = 0.5 * (mass * glm::dot(velocity, velocity) + glm::dot(spin, own)),
            .potential = -mass * glm::dot(glm::dvec3(gravity), position),
            .momentum = mass * velocity,
            .angular_momentum = own + glm::cross(position, mass * velocity)};
}

} // namespace brittle::physics
