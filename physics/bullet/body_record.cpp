#include "physics/bullet/body_record.h"

#include <algorithm>
#include <utility>

#include "physics/bullet/first_touch.h"

namespace brittle::physics {

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

void measure(BodyRecord& body) {
    body.reach = 0.0f;
    body.thickness = BT_LARGE_FLOAT;
    const auto add = [&](const HullShape& hull, const btVector3& origin) {
        body.reach = std::max(body.reach, origin.length() + hull.radius());
        body.thickness = std::min(body.thickness, thickness(hull));
    };
    if (!body.compound) return add(*body.shape, {0, 0, 0});
    for (int i = 0; i < body.compound->getNumChildShapes(); ++i)
        add(static_cast<const HullShape&>(*body.compound->getChildShape(i)), body.compound->getChildTransform(i).getOrigin());
}

void find_drag(BodyRecord& body, const BodyDesc& desc) {
    CrossSection section;
    const auto add = [&section](const CollisionHull& hull) {
        const CrossSection own = hull.section.sides.empty() ? cross_section(hull.points) : hull.section;
        section.sides.insert(section.sides.end(), own.sides.begin(), own.sides.end());
    };
    if (desc.parts.empty()) add(desc.hull);
    for (const BodyPart& part : desc.parts) add(*part.hull);
    if (desc.parts.size() > 1) section = bundled(section.sides);
    for (glm::vec3& side : section.sides) side = glm::conjugate(body.to_principal) * side;
    if (desc.parts.size() > 1) {
        btVector3 low, high;
        body.collision_shape()->getAabb(btTransform::getIdentity(), low, high);
        const CrossSection around = section_of_box(glm::dvec3(metres_from_bullet(high - low)) * 0.5,
                                                   {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)});
        if (around.mean() < section.mean()) section = around;
    }
    body.drag = AirDrag(section.sides, body.mass, body.moments);
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
