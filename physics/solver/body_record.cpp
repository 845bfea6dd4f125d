#include "physics/solver/body_record.h"

#include <algorithm>
#include <utility>

#include "physics/solver/first_touch.h"
#include "physics/solver/siblings.h"
#include "physics/solver/turn.h"
#include "physics/world/world_check.h"

namespace brittle::physics {

namespace {

// What is so many times as long as debris is large beside it. Of a thousand pieces that fall as debris onto a thousand of the same
// sizes there are 2,674 contacts that press where all count as large, 654 with 1.5, 326 with 2 and 192 with 3.
// With 3, before crowding(), steps after such a fall were shorter by a tenth; but thirty balls that are struck in a crowd then made 8 % more
// pieces, in twice as many steps: less of what breaks off holds up what is left, which breaks again.
constexpr float debris_factor = 2.0f;

// The shape of a body with one hull; to_principal must be known. Bullet's frame has the principal axes, so the hull is turned
// into them.
void make_single(BodyForm& body, const CollisionHull& hull, const glm::vec3& offset) {
    body.shape.emplace();
    body.shape->reserve(hull.points.size());
    const glm::quat from_body = glm::conjugate(body.to_principal);
    const size_t count = hull.points.size();
    const auto at = [&](size_t i) { return hull.points[std::min(i, count - 1)] + offset; };
    for (size_t first = 0; first < count; first += 4) {
        const Vector4 four = turned(from_body, Vector4::of(at(first), at(first + 1), at(first + 2), at(first + 3)));
        float x[4], y[4], z[4];
        four.x.store(x), four.y.store(y), four.z.store(z);
        for (size_t i = 0; i < std::min<size_t>(count - first, 4); ++i)
            body.shape->add(metres_to_bullet(glm::vec3(x[i], y[i], z[i])));
    }
    body.shape->setMargin(hull.margin * bullet_units);
    body.shape->finish();
}

float longest_extent(const btCollisionShape& shape) {
    btVector3 low, high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    const btVector3 size = high - low;
    return size[size.maxAxis()];
}

// Reach, thickness, longest.
void measure(BodyMeasures& body, const HullShape& hull) {
    body.longest = hull.longest();
    body.reach = hull.radius();
    body.thickness = thickness(hull);
}

void measure(BodyMeasures& body, const btCompoundShape& compound) {
    body.longest = longest_extent(compound);
    body.reach = 0.0f;
    body.thickness = BT_LARGE_FLOAT;
    for (int i = 0; i < compound.getNumChildShapes(); ++i) {
        const auto& hull = static_cast<const HullShape&>(*compound.getChildShape(i));
        body.reach = std::max(body.reach, compound.getChildTransform(i).getOrigin().length() + hull.radius());
        body.thickness = std::min(body.thickness, thickness(hull));
    }
}

// Of the hull in its own axes; most know it.
AirDrag drag_of_single(const BodyMeasures& body, const CollisionHull& hull) {
    const glm::quat from_body = glm::conjugate(body.to_principal);
    if (!hull.section.sides.empty()) return {hull.section.sides, from_body, body.mass, body.moments};
    return {cross_section(hull.points).sides, from_body, body.mass, body.moments};
}

AirDrag drag_of_compound(const BodyRecord& body, std::span<const BodyPart> parts) {
    std::vector<glm::vec3> all;
    for (const BodyPart& part : parts) {
        const CrossSection own =
            part.hull->section.sides.empty() ? cross_section(part.hull->points) : part.hull->section;
        all.insert(all.end(), own.sides.begin(), own.sides.end());
    }
    CrossSection section = bundled(all);
    for (glm::vec3& side : section.sides) side = glm::conjugate(body.to_principal) * side;
    btVector3 low, high;
    body.compound->getAabb(btTransform::getIdentity(), low, high);
    const CrossSection around = section_of_box(glm::dvec3(metres_from_bullet(high - low)) * 0.5,
                                               {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)});
    if (around.mean() < section.mean()) section = around;
    return {section.sides, glm::quat(1.0f, 0.0f, 0.0f, 0.0f), body.mass, body.moments};
}

// What moves is given its box as each step begins: until then one around it any way round will do, and saves a look at all of its
// points. What is astray from the first (SteppedWorld::set_box()) keeps that.
std::unique_ptr<SweptProxy> proxy_of(BodyRecord& body, bool large) {
    const btVector3 reach(body.reach, body.reach, body.reach);
    btVector3 low = body.blow_frame.getOrigin() - reach, high = body.blow_frame.getOrigin() + reach;
    if (body.fixed) body.collision_shape()->getAabb(body.blow_frame, low, high);
    return SweepBroadphase::make_proxy(low, high, &*body.rigid, group_of(body.fixed, body.debris),
                                       partners_of(body.fixed, body.debris),
                                       body.fixed || large ? BT_LARGE_FLOAT : body.longest, min_partner_of(body));
}

bool has_one_hull(const BodyDesc& desc) {
    return desc.parts.size() <= 1;
}

fracture::Error refused(std::string fault) {
    return {fracture::Status::invalid_setting, std::move(fault)};
}

// What is wrong, or nothing. Of several hulls the shape is left out, and what follows from it.
std::string describe(BodyForm& form, const BodyDesc& desc) {
    fracture::PrincipalAxes principal;
    if (std::string fault = fault_of_form(desc, principal); !fault.empty()) return fault;
    form.to_principal = glm::normalize(glm::quat(glm::quat_cast(principal.axes)));
    form.moments = principal.moments;
    form.mass = desc.mass;
    form.fixed = desc.fixed;
    if (!has_one_hull(desc)) return {};
    const CollisionHull& hull = desc.parts.empty() ? desc.hull : *desc.parts[0].hull;
    make_single(form, hull, desc.parts.empty() ? glm::vec3(0.0f) : desc.parts[0].offset);
    measure(form, *form.shape);
    if (!form.fixed) form.drag = drag_of_single(form, hull);
    return {};
}

} // namespace

Result<std::shared_ptr<const BodyForm>> make_form(const BodyDesc& desc) {
    auto form = std::make_shared<BodyForm>();
    if (std::string fault = describe(*form, desc); !fault.empty()) return refused(std::move(fault));
    return has_one_hull(desc) ? std::shared_ptr<const BodyForm>(std::move(form)) : nullptr;
}

Result<NewBody> make_body(const BodyDesc& desc, const WorldSettings& settings) {
    NewBody made;
    made.record = std::make_unique_for_overwrite<BodyRecord>(); // else all of it would be cleared first
    BodyRecord& body = *made.record;
    body.form = desc.form;
    if (!body.form) {
        auto form = std::make_shared<BodyForm>();
        if (std::string fault = describe(*form, desc); !fault.empty()) return refused(std::move(fault));
        body.form = std::move(form);
    }
    static_cast<BodyMeasures&>(body) = *body.form;
    if (std::string fault = fault_of_place(desc); !fault.empty()) return refused(std::move(fault));
    const glm::quat orientation = glm::normalize(desc.pose.orientation);
    body.blow_frame = btTransform(to_bullet(orientation * body.to_principal), metres_to_bullet(desc.pose.position));
    if (!body.fixed) body.solved = {metres_to_bullet(desc.linear_velocity), to_bullet(desc.angular_velocity)};
    body.unhindered = body.solved;
    if (desc.previous)
        body.previous = {desc.previous->position, glm::normalize(desc.previous->orientation)};
    else
        body.previous = body.pose_in(body.blow_frame);
    if (desc.form || has_one_hull(desc)) make_rigid(made, desc, settings);
    return made;
}

void finish_compound(BodyRecord& body, std::span<const BodyPart> parts) {
    measure(body, *body.compound);
    auto form = std::make_shared<BodyForm>();
    static_cast<BodyMeasures&>(*form) = body;
    if (!body.fixed) form->drag = drag_of_compound(body, parts);
    body.form = std::move(form);
}

const btRigidBody& blank_body() {
    static const btRigidBody blank(btRigidBody::btRigidBodyConstructionInfo(1.0f, nullptr, nullptr));
    return blank;
}

void make_rigid(NewBody& made, const BodyDesc& desc, const WorldSettings& settings) {
    BodyRecord& body = *made.record;
    btRigidBody& rigid = body.rigid.emplace(blank_body());
    rigid.setWorldTransform(body.blow_frame);
    rigid.setInterpolationWorldTransform(body.blow_frame);
    rigid.setCollisionShape(body.collision_shape());
    rigid.setFriction(desc.friction);
    rigid.setRestitution(desc.restitution);
    rigid.setDamping(settings.linear_damping, settings.angular_damping);
    if (body.fixed)
        rigid.setMassProps(0.0f, {0, 0, 0});
    else
        rigid.setMassProps(body.mass, metres_to_bullet(glm::vec3(body.moments) * bullet_units));
    rigid.updateInertiaTensor();
    if (!body.fixed) rigid.setGravity(metres_to_bullet(settings.gravity));
    rigid.setLinearVelocity(body.solved.linear);
    rigid.setAngularVelocity(body.solved.angular);
    rigid.setFlags(0); // no gyroscopic term of Bullet's: see rotation.h
    if (!settings.sleeping) rigid.setActivationState(DISABLE_DEACTIVATION);
    if (body.fixed) rigid.setActivationState(ISLAND_SLEEPING);
    body.debris = !body.fixed && (desc.debris || body.longest < settings.debris_size * bullet_units);
    if (desc.siblings != 0) Siblings::mark(rigid, desc.siblings);
    made.sibling = desc.siblings != 0;
    made.awake = body.awake();
    made.debris = body.debris;
    made.proxy = proxy_of(body, desc.large);
    rigid.setBroadphaseHandle(made.proxy.get());
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

int group_of(bool fixed, bool debris) {
    return fixed    ? btBroadphaseProxy::StaticFilter
           : debris ? btBroadphaseProxy::DebrisFilter
                    : btBroadphaseProxy::DefaultFilter;
}

int partners_of(bool fixed, bool debris) {
    return fixed || debris ? btBroadphaseProxy::AllFilter ^ group_of(fixed, debris)
                           : static_cast<int>(btBroadphaseProxy::AllFilter);
}

float min_partner_of(const BodyRecord& body) {
    return body.debris ? debris_factor * body.longest : 0.0f;
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
