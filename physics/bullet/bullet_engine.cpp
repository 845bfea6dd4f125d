#include "physics/bullet/bullet_engine.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include <LinearMath/btAabbUtil2.h>
#include <btBulletDynamicsCommon.h>
#include <glm/geometric.hpp>

#include "physics/bullet/bullet_joint.h"
#include "physics/world/body_form.h"
#include "physics/world/world_check.h"

namespace brittle::physics {

namespace {

constexpr float units = 10.0f; // Bullet's lengths per metre
constexpr int iterations = 20; // of its contact solver
// The largest moment of inertia, and moment times turn in a step, whose cube fits in single precision: kg dm^2.
constexpr double max_gyroscopic = 1e12;
constexpr btScalar ray_room = 0.1f;                // decimetres; a ray is cast from so far before a body's bounds
constexpr float max_speed = 1e5f, max_spin = 1e5f; // m/s, rad/s, at the beginning of a step

// Quantities without a factor of length: axes, angular velocities.
btVector3 to_bullet(const glm::vec3& v) {
    return {v.x, v.y, v.z};
}
// Quantities with one factor of length: positions, velocities, accelerations, impulses.
btVector3 metres_to_bullet(const glm::vec3& v) {
    return to_bullet(v * units);
}
btQuaternion to_bullet(const glm::quat& q) {
    return {q.x, q.y, q.z, q.w};
}
glm::vec3 to_glm(const btVector3& v) {
    return {v.x(), v.y(), v.z()};
}
glm::vec3 metres_from_bullet(const btVector3& v) {
    return to_glm(v) / units;
}
glm::quat to_glm(const btQuaternion& q) {
    return {q.w(), q.x(), q.y(), q.z()};
}

// The first hull of one body or several that a ray of Bullet's enters.
struct FirstHull final : btCollisionWorld::ClosestRayResultCallback {
    uint32_t part = 0;

    using ClosestRayResultCallback::ClosestRayResultCallback;
    btScalar addSingleResult(btCollisionWorld::LocalRayResult& result, bool in_world) override {
        part = result.m_localShapeInfo ? static_cast<uint32_t>(result.m_localShapeInfo->m_triangleIndex) : 0;
        return ClosestRayResultCallback::addSingleResult(result, in_world);
    }
    [[nodiscard]] btVector3 point() const {
        return m_rayFromWorld + m_closestHitFraction * (m_rayToWorld - m_rayFromWorld);
    }
};

// Bullet's cast of a point against a hull sometimes ends a centimetre early. A cast from the place that it found ends
// there if the place is right, and nearer to the hull if it is not.
std::optional<FirstHull> first_hull(btRigidBody& body, const btVector3& from, const btVector3& to) {
    constexpr int casts = 2;
    const btQuaternion unturned = btQuaternion::getIdentity();
    const btVector3 along = to - from;
    btScalar begin = 0.0f;
    std::optional<FirstHull> found;
    for (int cast = 0; cast < casts; ++cast) {
        found.emplace(from + begin * along, to);
        btCollisionWorld::rayTestSingle(btTransform(unturned, found->m_rayFromWorld), btTransform(unturned, to), &body,
                                        body.getCollisionShape(), body.getWorldTransform(), *found);
        if (!found->hasHit()) return std::nullopt;
        begin = std::max(0.0f, begin + found->m_closestHitFraction * (1.0f - begin) - ray_room / along.length());
    }
    return found;
}

// Bullet's globals: counters of bodies, allocations and profiles.
std::mutex& bullet_mutex() {
    static std::mutex mutex;
    return mutex;
}

struct Velocity {
    btVector3 linear{0, 0, 0}, angular{0, 0, 0};
};

// Bullet keeps the contacts that it predicts for fast bodies until its next step. removeRigidBody() leaves those of the
// body that it removes, with their pointers to it.
class DynamicsWorld final : public btDiscreteDynamicsWorld {
  public:
    using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;

    void forget_predicted_contacts(const btRigidBody& body) {
        for (int i = m_predictiveManifolds.size(); i-- > 0;) {
            btPersistentManifold* const manifold = m_predictiveManifolds[i];
            if (manifold->getBody0() != &body && manifold->getBody1() != &body) continue;
            m_dispatcher1->releaseManifold(manifold);
            m_predictiveManifolds.removeAtIndex(i);
        }
    }
};

// Bullet's frame of a body has its origin at the centre of mass and its axes along the principal axes of inertia.
struct BulletBody {
    BodyId id;
    float mass = 0.0f; // kg, also of a fixed body
    bool fixed = false, debris = false;
    glm::quat to_principal{1.0f, 0.0f, 0.0f, 0.0f}; // body axes = to_principal * principal axes
    glm::dvec3 moments{1.0};                        // kg m^2
    std::vector<std::unique_ptr<btConvexHullShape>> hulls;
    std::unique_ptr<btCompoundShape> compound; // null for one hull
    std::unique_ptr<btRigidBody> rigid;
    // At the start of the last step: the frame, and the velocity with the step's gravity. Then the velocity after it.
    btTransform step_start = btTransform::getIdentity();
    Velocity unhindered, solved;
    float rewind_seconds = 0.0f; // from that frame to the present one; 0 for a body that was added after the step

    [[nodiscard]] Velocity velocity() const { return {rigid->getLinearVelocity(), rigid->getAngularVelocity()}; }
    [[nodiscard]] Pose pose() const {
        const btTransform& frame = rigid->getWorldTransform();
        return {metres_from_bullet(frame.getOrigin()), to_glm(frame.getRotation()) * glm::conjugate(to_principal)};
    }
};

struct BulletJoint {
    JointId id;
    BulletBody *a = nullptr, *b = nullptr; // null: the world
    JointKind kind = JointKind::ball;
    btVector3 in_a{0, 0, 0}, in_b{0, 0, 0}, axis{0, 0, 0}; // the axis in a's frame
    float max_force = 0.0f, max_torque = 0.0f;             // N, N m
    bool bears_pressure = false;
    std::unique_ptr<btTypedConstraint> constraint; // null between two sides that never move
    std::unique_ptr<btJointFeedback> feedback;     // of the last step, in Bullet's units

    // N
    [[nodiscard]] float force() const { return feedback->m_appliedForceBodyA.length() / units; }
    // What the joint gave in the last step, as a share of what it bears.
    [[nodiscard]] float load_share() const {
        if (kind != JointKind::fixed) return force() / max_force;
        const btMatrix3x3 basis = a ? a->rigid->getWorldTransform().getBasis() : btMatrix3x3::getIdentity();
        const btVector3 to_b = basis * axis;
        btVector3 pull = feedback->m_appliedForceBodyA;
        const btVector3 torque = feedback->m_appliedTorqueBodyA - (basis * in_a).cross(pull);
        if (bears_pressure) pull -= std::min(pull.dot(to_b), btScalar(0)) * to_b;
        return pull.length() / units / max_force + torque.length() / (units * units) / max_torque;
    }
};

class BulletEngine final : public Engine {
  public:
    explicit BulletEngine(const WorldSettings& settings);
    ~BulletEngine() override;

    Result<void> add(size_t count, BodyId first, const Describe& describe, std::span<Pose> previous) override;
    void remove(size_t body) override;
    void step() override;
    [[nodiscard]] std::span<const uint8_t> moved() const override { return moved_; }
    [[nodiscard]] AwakeCount awake_count() const override;

    [[nodiscard]] Pose pose(size_t body) const override { return bodies_[body]->pose(); }
    void write_poses(std::span<const uint64_t> moved_steps, uint64_t since, std::span<Pose> out) const override {
        for (size_t i = 0; i < out.size(); ++i)
            if (moved_steps[i] >= since) out[i] = pose(i);
    }
    [[nodiscard]] glm::vec3 linear_velocity(size_t body) const override {
        return metres_from_bullet(bodies_[body]->rigid->getLinearVelocity());
    }
    [[nodiscard]] glm::vec3 angular_velocity(size_t body) const override {
        return to_glm(bodies_[body]->rigid->getAngularVelocity());
    }
    [[nodiscard]] float mass(size_t body) const override { return bodies_[body]->mass; }
    [[nodiscard]] bool fixed(size_t body) const override { return bodies_[body]->fixed; }
    [[nodiscard]] bool debris(size_t body) const override { return bodies_[body]->debris; }
    [[nodiscard]] bool awake(size_t body) const override {
        return !bodies_[body]->fixed && bodies_[body]->rigid->isActive();
    }
    [[nodiscard]] Mechanics mechanics(size_t body) const override;
    [[nodiscard]] float response(size_t body, const glm::vec3& point, const glm::vec3& direction) const override {
        return bodies_[body]->rigid->computeImpulseDenominator(metres_to_bullet(point), to_bullet(direction));
    }

    [[nodiscard]] BodyId stopped_by(size_t) const override { return {}; }
    [[nodiscard]] glm::mat3 inverse_inertia(size_t body) const override {
        const btMatrix3x3& inverse = bodies_[body]->rigid->getInvInertiaTensorWorld();
        glm::mat3 result;
        for (int column = 0; column < 3; ++column) result[column] = to_glm(inverse.getColumn(column)) * (units * units);
        return result;
    }

    void wake(size_t body) override {
        if (!bodies_[body]->fixed) bodies_[body]->rigid->activate(true);
    }
    void apply_impulse(size_t body, const glm::vec3& impulse, const glm::vec3& point) override;
    void set_velocity(size_t body, const glm::vec3& linear, const glm::vec3& angular) override;
    float rewind(size_t body) override;
    void move_on(size_t body, float seconds) override;

    void add_joint(JointId id, const Joint& joint, const JointBodies& bodies) override;
    void remove_joint(JointId id) override;
    [[nodiscard]] float joint_force(JointId id) const override { return (*find(id))->force(); }
    [[nodiscard]] std::span<const JointId> broken_joints() const override { return broken_; }

    [[nodiscard]] std::span<const Contact> contacts() override;
    [[nodiscard]] std::span<const Contact> solved_contacts() override;
    [[nodiscard]] std::vector<CastHit> cast(size_t, size_t, float) const override { return {}; }
    void cast_rays(std::span<const Ray> rays, std::span<std::optional<RayHit>> hits) const override;
    void amend_contact(size_t index, const Contact& contact) override { contacts_[index] = contact; }
    [[nodiscard]] size_t contact_count() const override;

    void add_state(StateHash& hash) const override;
    void debug_lines(std::vector<DebugLine>& out, const DebugDraw& draw) override;

  private:
    static constexpr int no_body = -1; // the user index of the ground

    [[nodiscard]] Result<std::unique_ptr<BulletBody>> make(BodyId id, const BodyDesc& desc) const;
    btConvexHullShape& add_hull(BulletBody& body, const CollisionHull& hull, const glm::quat& rotation) const;
    void set_ccd(BulletBody& body) const;
    void limit_velocity(BulletBody& body) const;
    void limit_gyroscopic(BulletBody& body) const;
    using JointList = std::vector<std::unique_ptr<BulletJoint>>;
    [[nodiscard]] JointList::const_iterator find(JointId id) const {
        return std::ranges::lower_bound(joints_, id, {}, [](const auto& joint) { return joint->id; });
    }
    void end_joint(JointList::const_iterator joint);
    void note_joints();
    [[nodiscard]] const BulletBody* body_of(const btCollisionObject* object) const;
    [[nodiscard]] Contact report_of(const btPersistentManifold& manifold, const btManifoldPoint& point) const;
    void report();
    void for_each_manifold(const auto& visit) const {
        for (int i = 0; i < dispatcher_.getNumManifolds(); ++i)
            visit(*const_cast<btCollisionDispatcher&>(dispatcher_).getManifoldByIndexInternal(i));
    }

    WorldSettings settings_;
    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_{&configuration_};
    btDbvtBroadphase broadphase_;
    btSequentialImpulseConstraintSolver solver_;
    DynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
    std::unique_ptr<btStaticPlaneShape> ground_shape_;
    std::unique_ptr<btRigidBody> ground_;
    std::vector<std::unique_ptr<BulletBody>> bodies_; // in body order; the rigid bodies' user index points here
    JointList joints_;                                // ascending
    std::vector<JointId> broken_;                     // in the last step
    std::vector<uint8_t> moved_;
    std::vector<Contact> contacts_;
    size_t solved_count_ = 0; // of contacts_: those with an awake body come first
    bool reported_ = true;
};

BulletEngine::BulletEngine(const WorldSettings& settings) : settings_(settings) {
    const std::lock_guard lock(bullet_mutex());
    world_.setGravity(metres_to_bullet(settings.gravity));
    btContactSolverInfo& info = world_.getSolverInfo();
    info.m_numIterations = iterations;
    info.m_splitImpulse = 1;
    if (!settings.ground_height) return;
    ground_shape_ = std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), *settings.ground_height * units);
    ground_ =
        std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(0.0f, nullptr, ground_shape_.get()));
    ground_->setFriction(settings.ground_friction);
    ground_->setRestitution(settings.ground_restitution);
    ground_->setUserIndex(no_body);
    world_.addRigidBody(ground_.get());
}

BulletEngine::~BulletEngine() {
    const std::lock_guard lock(bullet_mutex());
    while (!joints_.empty()) end_joint(joints_.begin());
    for (size_t i = bodies_.size(); i-- > 0;) world_.removeRigidBody(bodies_[i]->rigid.get());
    if (ground_) world_.removeRigidBody(ground_.get());
}

btConvexHullShape& BulletEngine::add_hull(BulletBody& body, const CollisionHull& hull,
                                          const glm::quat& rotation) const {
    auto shape = std::make_unique<btConvexHullShape>();
    for (const glm::vec3& point : hull.points) shape->addPoint(metres_to_bullet(rotation * point), false);
    shape->setMargin(hull.margin * units);
    shape->recalcLocalAabb();
    return *body.hulls.emplace_back(std::move(shape));
}

// Bullet's continuous collision sweeps a sphere that fits into the body against fixed bodies.
void BulletEngine::set_ccd(BulletBody& body) const {
    float thickness = BT_LARGE_FLOAT;
    for (const auto& hull : body.hulls)
        thickness = std::min(thickness, hull->getMargin() / HullSettings{}.margin_fraction);
    body.rigid->setCcdMotionThreshold(0.5f * thickness);
    body.rigid->setCcdSweptSphereRadius(0.2f * thickness);
}

Result<std::unique_ptr<BulletBody>> BulletEngine::make(BodyId id, const BodyDesc& given) const {
    BodyDesc desc = given;
    if (given.form) {
        desc.hull = given.form->hull;
        desc.parts.clear();
        desc.mass = given.form->mass;
        desc.inertia = given.form->inertia;
        desc.fixed = given.form->fixed;
    }
    const auto refused = [&](const std::string& fault) {
        return fracture::Error{fracture::Status::invalid_setting, text(id, " cannot be added: ", fault)};
    };
    fracture::PrincipalAxes principal;
    if (const std::string fault = fault_of_form(desc, principal); !fault.empty()) return refused(fault);
    if (const std::string fault = fault_of_place(desc); !fault.empty()) return refused(fault);
    auto body = std::make_unique<BulletBody>();
    body->id = id;
    body->mass = desc.mass;
    body->fixed = desc.fixed;
    body->moments = principal.moments;
    body->to_principal = glm::normalize(glm::quat(glm::quat_cast(principal.axes)));
    const glm::quat from_body = glm::conjugate(body->to_principal);
    btCollisionShape* shape = nullptr;
    if (desc.parts.empty()) {
        shape = &add_hull(*body, desc.hull, from_body);
    } else {
        body->compound = std::make_unique<btCompoundShape>();
        for (const BodyPart& part : desc.parts)
            body->compound->addChildShape(
                btTransform(btQuaternion::getIdentity(), metres_to_bullet(from_body * part.offset)),
                &add_hull(*body, *part.hull, from_body));
        shape = body->compound.get();
    }
    const btVector3 inertia = metres_to_bullet(glm::vec3(body->moments) * units);
    btRigidBody::btRigidBodyConstructionInfo info(body->fixed ? 0.0f : body->mass, nullptr, shape,
                                                  body->fixed ? btVector3(0, 0, 0) : inertia);
    info.m_startWorldTransform = btTransform(to_bullet(glm::normalize(desc.pose.orientation) * body->to_principal),
                                             metres_to_bullet(desc.pose.position));
    info.m_friction = desc.friction;
    info.m_restitution = desc.restitution;
    info.m_linearDamping = settings_.linear_damping;
    info.m_angularDamping = settings_.angular_damping;
    info.m_linearSleepingThreshold = settings_.sleep_linear_speed * units;
    info.m_angularSleepingThreshold = settings_.sleep_angular_speed;
    body->rigid = std::make_unique<btRigidBody>(info);
    body->step_start = info.m_startWorldTransform;
    if (!body->fixed) {
        body->rigid->setLinearVelocity(metres_to_bullet(desc.linear_velocity));
        body->rigid->setAngularVelocity(to_bullet(desc.angular_velocity));
        if (!settings_.sleeping) body->rigid->setActivationState(DISABLE_DEACTIVATION);
        set_ccd(*body);
    }
    body->unhindered = body->solved = body->velocity();
    btVector3 low, high;
    shape->getAabb(btTransform::getIdentity(), low, high);
    const btVector3 size = high - low;
    body->debris = !body->fixed && (desc.debris || size[size.maxAxis()] < settings_.debris_size * units);
    return body;
}

Result<void> BulletEngine::add(size_t count, BodyId first, const Describe& describe, std::span<Pose> previous) {
    const std::lock_guard lock(bullet_mutex());
    std::vector<std::unique_ptr<BulletBody>> made;
    BodyDesc storage;
    for (size_t i = 0; i < count; ++i) {
        const BodyDesc& desc = describe(i, storage);
        Result<std::unique_ptr<BulletBody>> body = make({first.value + static_cast<uint32_t>(i)}, desc);
        if (!body) return body.error();
        previous[i] =
            desc.previous ? Pose{desc.previous->position, glm::normalize(desc.previous->orientation)} : (*body)->pose();
        made.push_back(std::move(*body));
    }
    for (auto& body : made) {
        body->rigid->setUserIndex(static_cast<int>(bodies_.size()));
        const int group = body->fixed    ? btBroadphaseProxy::StaticFilter
                          : body->debris ? btBroadphaseProxy::DebrisFilter
                                         : btBroadphaseProxy::DefaultFilter;
        const int partners = group == btBroadphaseProxy::DefaultFilter ? static_cast<int>(btBroadphaseProxy::AllFilter)
                                                                       : btBroadphaseProxy::AllFilter ^ group;
        world_.addRigidBody(body->rigid.get(), group, partners);
        bodies_.push_back(std::move(body));
    }
    return {};
}

void BulletEngine::remove(size_t index) {
    const std::lock_guard lock(bullet_mutex());
    report();
    btRigidBody* const leaving = bodies_[index]->rigid.get();
    for_each_manifold([&](const btPersistentManifold& manifold) {
        if (manifold.getNumContacts() == 0) return;
        for (const auto& [own, other] :
             {std::pair(manifold.getBody0(), manifold.getBody1()), {manifold.getBody1(), manifold.getBody0()}})
            if (own == leaving && !other->isStaticObject()) other->activate(true);
    });
    world_.forget_predicted_contacts(*leaving);
    world_.removeRigidBody(leaving);
    bodies_.erase(bodies_.begin() + static_cast<std::ptrdiff_t>(index));
    for (size_t i = index; i < bodies_.size(); ++i) bodies_[i]->rigid->setUserIndex(static_cast<int>(i));
}

// Bullet's solver loses a body to NaN where the velocities of heavy and light ones differ by more.
void BulletEngine::limit_velocity(BulletBody& body) const {
    const btVector3 &linear = body.rigid->getLinearVelocity(), &angular = body.rigid->getAngularVelocity();
    if (const float speed = linear.length(); speed > max_speed * units)
        body.rigid->setLinearVelocity(linear * (max_speed * units / speed));
    if (const float spin = angular.length(); spin > max_spin)
        body.rigid->setAngularVelocity(angular * (max_spin / spin));
}

// Bullet finds the gyroscopic torque from a determinant of moments times turns. Where that is beyond single precision,
// the body goes without the torque instead of to no place.
void BulletEngine::limit_gyroscopic(BulletBody& body) const {
    const glm::dvec3& m = body.moments;
    const double moment = std::max({m.x, m.y, m.z}) * static_cast<double>(units * units);
    const double turn =
        glm::length(glm::dvec3(to_glm(body.rigid->getAngularVelocity()))) * static_cast<double>(settings_.step);
    const int flag = BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY, others = body.rigid->getFlags() & ~flag;
    body.rigid->setFlags(moment * std::max(turn, 1.0) > max_gyroscopic ? others : others | flag);
}

void BulletEngine::step() {
    const std::lock_guard lock(bullet_mutex());
    const btVector3 fall = world_.getGravity() * settings_.step;
    for (const auto& body : bodies_) {
        body->step_start = body->rigid->getWorldTransform();
        body->rewind_seconds = settings_.step;
        if (!body->fixed) {
            limit_velocity(*body);
            limit_gyroscopic(*body);
        }
        body->unhindered = body->velocity();
        if (!body->fixed && body->rigid->isActive()) body->unhindered.linear += fall;
    }
    for (const auto& joint : joints_) *joint->feedback = {};
    const btScalar deactivation = std::exchange(gDeactivationTime, settings_.sleep_seconds);
    world_.stepSimulation(settings_.step, 0); // one step of exactly that length
    gDeactivationTime = deactivation;
    moved_.assign(bodies_.size(), 0);
    for (size_t i = 0; i < bodies_.size(); ++i) {
        BulletBody& body = *bodies_[i];
        moved_[i] = !(body.rigid->getWorldTransform() == body.step_start);
        body.solved = body.velocity();
    }
    note_joints();
    contacts_.clear();
    reported_ = false;
}

void BulletEngine::add_joint(JointId id, const Joint& joint, const JointBodies& bodies) {
    const std::lock_guard lock(bullet_mutex());
    auto made = std::make_unique<BulletJoint>();
    made->id = id;
    made->kind = joint.kind;
    made->max_force = joint.max_force;
    made->max_torque = joint.max_torque;
    made->bears_pressure = joint.bears_pressure;
    made->feedback = std::make_unique<btJointFeedback>();
    *made->feedback = {};
    const auto body_of = [&](size_t index) { return index == JointBodies::none ? nullptr : bodies_[index].get(); };
    made->a = body_of(bodies.a);
    made->b = body_of(bodies.b);
    const auto in = [](const BulletBody* body, const glm::vec3& v) {
        return body ? glm::conjugate(body->to_principal) * v : v;
    };
    const auto rigid_of = [](const BulletBody* body) -> btRigidBody& {
        return body ? *body->rigid : btTypedConstraint::getFixedBody();
    };
    btRigidBody &a = rigid_of(made->a), &b = rigid_of(made->b);
    made->in_a = metres_to_bullet(in(made->a, joint.a.anchor));
    made->in_b = metres_to_bullet(in(made->b, joint.b.anchor));
    made->axis = to_bullet(in(made->a, joint.a.axis));
    const bool moves = (made->a && !made->a->fixed) || (made->b && !made->b->fixed);
    if (moves && joint.kind == JointKind::ball)
        made->constraint = std::make_unique<btPoint2PointConstraint>(a, b, made->in_a, made->in_b);
    else if (moves && joint.kind == JointKind::hinge)
        made->constraint = std::make_unique<btHingeConstraint>(a, b, made->in_a, made->in_b, made->axis,
                                                               to_bullet(in(made->b, joint.b.axis)));
    else if (moves && joint.kind == JointKind::fixed)
        made->constraint = std::make_unique<btFixedConstraint>(
            a, b, joint_frame(made->in_a, made->axis, to_bullet(in(made->a, joint.a.up))),
            joint_frame(made->in_b, to_bullet(in(made->b, joint.b.axis)), to_bullet(in(made->b, joint.b.up))));
    else if (moves)
        made->constraint = std::make_unique<BulletDistance>(a, b, made->in_a, made->in_b, joint.min_length * units,
                                                            joint.max_length * units);
    if (moves) {
        made->constraint->setJointFeedback(made->feedback.get());
        world_.addConstraint(made->constraint.get(), !joint.collide);
    }
    for (const BulletBody* body : {made->a, made->b})
        if (body && !body->fixed) body->rigid->activate(true);
    joints_.insert(find(id), std::move(made));
}

void BulletEngine::end_joint(JointList::const_iterator joint) {
    if ((*joint)->constraint) world_.removeConstraint((*joint)->constraint.get());
    for (const BulletBody* body : {(*joint)->a, (*joint)->b})
        if (body && !body->fixed) body->rigid->activate(true);
    joints_.erase(joint);
}

void BulletEngine::remove_joint(JointId id) {
    const std::lock_guard lock(bullet_mutex());
    end_joint(find(id));
}

// Adds the joints' impulses to the velocities that rewind() restores, and ends overloaded joints.
void BulletEngine::note_joints() {
    broken_.clear();
    for (const auto& joint : joints_) {
        const auto push = [&](BulletBody* body, const btVector3& force, const btVector3& torque) {
            if (!body || body->fixed) return;
            body->unhindered.linear += force * (settings_.step * body->rigid->getInvMass());
            body->unhindered.angular += body->rigid->getInvInertiaTensorWorld() * torque * settings_.step;
        };
        push(joint->a, joint->feedback->m_appliedForceBodyA, joint->feedback->m_appliedTorqueBodyA);
        push(joint->b, joint->feedback->m_appliedForceBodyB, joint->feedback->m_appliedTorqueBodyB);
        if (joint->load_share() > 1.0f) broken_.push_back(joint->id);
    }
    for (const JointId id : broken_) end_joint(find(id));
}

AwakeCount BulletEngine::awake_count() const {
    AwakeCount count;
    for (size_t i = 0; i < bodies_.size(); ++i)
        if (awake(i)) ++count.of(bodies_[i]->debris);
    return count;
}

Mechanics BulletEngine::mechanics(size_t index) const {
    const BulletBody& body = *bodies_[index];
    if (body.fixed) return {};
    const double mass = body.mass;
    const glm::dvec3 position(pose(index).position), velocity(linear_velocity(index)), spin(angular_velocity(index));
    const glm::dquat orientation = glm::normalize(glm::dquat(to_glm(body.rigid->getOrientation())));
    const glm::dvec3 angular = orientation * (body.moments * (glm::conjugate(orientation) * spin));
    return {.kinetic = 0.5 * (mass * glm::dot(velocity, velocity) + glm::dot(spin, angular)),
            .potential = -mass * glm::dot(glm::dvec3(settings_.gravity), position),
            .momentum = mass * velocity,
            .angular_momentum = angular + glm::cross(position, mass * velocity)};
}

void BulletEngine::apply_impulse(size_t index, const glm::vec3& impulse, const glm::vec3& point) {
    wake(index);
    btRigidBody& rigid = *bodies_[index]->rigid;
    rigid.applyImpulse(metres_to_bullet(impulse), metres_to_bullet(point) - rigid.getCenterOfMassPosition());
}

void BulletEngine::set_velocity(size_t index, const glm::vec3& linear, const glm::vec3& angular) {
    wake(index);
    bodies_[index]->rigid->setLinearVelocity(metres_to_bullet(linear));
    bodies_[index]->rigid->setAngularVelocity(to_bullet(angular));
}

// Other changes of velocity since the step remain.
float BulletEngine::rewind(size_t index) {
    BulletBody& body = *bodies_[index];
    wake(index);
    body.rigid->setCenterOfMassTransform(body.step_start);
    body.rigid->setLinearVelocity(body.rigid->getLinearVelocity() + body.unhindered.linear - body.solved.linear);
    body.rigid->setAngularVelocity(body.rigid->getAngularVelocity() + body.unhindered.angular - body.solved.angular);
    body.unhindered = body.solved = body.velocity();
    return body.rewind_seconds;
}

void BulletEngine::move_on(size_t index, float seconds) {
    BulletBody& body = *bodies_[index];
    body.step_start = body.rigid->getWorldTransform();
    body.rewind_seconds = seconds;
    btTransform ahead;
    body.rigid->predictIntegratedTransform(seconds, ahead);
    body.rigid->setCenterOfMassTransform(ahead);
    body.solved = body.velocity();
}

// Bullet's own rayTest() knows bodies by their bounds before the last step. Each body is given the part of the ray near
// it: on long rays Bullet loses digits.
void BulletEngine::cast_rays(std::span<const Ray> rays, std::span<std::optional<RayHit>> hits) const {
    const std::lock_guard lock(bullet_mutex());
    const btVector3 room(ray_room, ray_room, ray_room);
    std::vector<std::pair<btVector3, btVector3>> boxes(bodies_.size());
    for (size_t k = 0; k < bodies_.size(); ++k) {
        bodies_[k]->rigid->getAabb(boxes[k].first, boxes[k].second);
        boxes[k].first -= room;
        boxes[k].second += room;
    }
    for (size_t i = 0; i < rays.size(); ++i) {
        if (!can_be_cast(rays[i])) continue;
        const btVector3 from = metres_to_bullet(rays[i].from), along = metres_to_bullet(rays[i].to) - from;
        btVector3 least = from, most = from;
        least.setMin(from + along);
        most.setMax(from + along);
        btScalar first = 1.0f;
        for (size_t k = 0; k < bodies_.size(); ++k) {
            btScalar enters = 1.0f, leaves = 1.0f; // shares of the ray; the second from its end
            btVector3 normal;
            const auto& [low, high] = boxes[k];
            if (!TestAabbAgainstAabb2(least, most, low, high)) continue;
            if (!btRayAabb(from, from + along, low, high, enters, normal) || enters >= first) continue;
            if (!btRayAabb(from + along, from, low, high, leaves, normal)) continue;
            const std::optional<FirstHull> hull =
                first_hull(*bodies_[k]->rigid, from + enters * along, from + (1.0f - leaves) * along);
            if (!hull) continue;
            const btScalar share = (hull->point() - from).dot(along) / along.length2();
            if (share >= first) continue;
            first = share;
            hits[i] = RayHit{.body = bodies_[k]->id,
                             .part = hull->part,
                             .share = share,
                             .point = rays[i].from + share * (rays[i].to - rays[i].from),
                             .normal = to_glm(hull->m_hitNormalWorld)};
        }
    }
}

const BulletBody* BulletEngine::body_of(const btCollisionObject* object) const {
    return object->getUserIndex() == no_body ? nullptr : bodies_[static_cast<size_t>(object->getUserIndex())].get();
}

// The ground is never the first body.
Contact BulletEngine::report_of(const btPersistentManifold& manifold, const btManifoldPoint& point) const {
    const BulletBody *a = body_of(manifold.getBody0()), *b = body_of(manifold.getBody1());
    const bool swapped = a == nullptr;
    if (swapped) std::swap(a, b);
    const float sign = swapped ? -1.0f : 1.0f;
    Contact contact;
    contact.a = a->id;
    if (b) contact.b = b->id;
    contact.part_a = static_cast<uint32_t>(std::max(swapped ? point.m_index1 : point.m_index0, 0));
    contact.part_b = b ? static_cast<uint32_t>(std::max(point.m_index1, 0)) : 0;
    contact.normal = sign * to_glm(point.m_normalWorldOnB);
    const bool on_a = !b || b->fixed;
    contact.point = metres_from_bullet(on_a != swapped ? point.getPositionWorldOnA() : point.getPositionWorldOnB());
    contact.impulse = contact.blow = point.m_appliedImpulse / units;
    contact.friction = sign
                       * metres_from_bullet(point.m_lateralFrictionDir1 * point.m_appliedImpulseLateral1
                                            + point.m_lateralFrictionDir2 * point.m_appliedImpulseLateral2);
    contact.gap = point.getDistance() / units;
    const btVector3 at = metres_to_bullet(contact.point);
    const auto velocity_at = [&](const BulletBody* body) {
        if (!body || body->fixed) return glm::vec3(0.0f);
        return metres_from_bullet(body->unhindered.linear
                                  + body->unhindered.angular.cross(at - body->step_start.getOrigin()));
    };
    // Before the step's gravity, which is the same for two moving bodies.
    const glm::vec3 gravity = b && !b->fixed ? glm::vec3(0.0f) : settings_.gravity * settings_.step;
    contact.speed = -glm::dot(velocity_at(a) - velocity_at(b) - gravity, contact.normal);
    return contact;
}

void BulletEngine::report() {
    if (std::exchange(reported_, true)) return;
    for (const bool active : {true, false}) {
        for_each_manifold([&](const btPersistentManifold& manifold) {
            const auto is_awake = [](const btCollisionObject& o) { return !o.isStaticObject() && o.isActive(); };
            if ((is_awake(*manifold.getBody0()) || is_awake(*manifold.getBody1())) != active) return;
            for (int p = 0; p < manifold.getNumContacts(); ++p)
                if (manifold.getContactPoint(p).m_appliedImpulse > 0.0f)
                    contacts_.push_back(report_of(manifold, manifold.getContactPoint(p)));
        });
        if (active) solved_count_ = contacts_.size();
    }
}

std::span<const Contact> BulletEngine::contacts() {
    report();
    return contacts_;
}

std::span<const Contact> BulletEngine::solved_contacts() {
    report();
    return std::span(contacts_).first(solved_count_);
}

size_t BulletEngine::contact_count() const {
    size_t count = 0;
    for_each_manifold([&](const btPersistentManifold& manifold) {
        for (int p = 0; p < manifold.getNumContacts(); ++p)
            count += manifold.getContactPoint(p).getDistance() < touching_distance * units ? 1u : 0u;
    });
    return count;
}

void BulletEngine::add_state(StateHash& hash) const {
    for (const auto& body : bodies_) {
        const btTransform& frame = body->rigid->getWorldTransform();
        for (const btVector3& v : {frame.getOrigin(), frame.getBasis()[0], frame.getBasis()[1], frame.getBasis()[2],
                                   body->rigid->getLinearVelocity(), body->rigid->getAngularVelocity()})
            for (int axis = 0; axis < 3; ++axis) hash.add(v[axis]);
        hash.add(static_cast<uint8_t>(body->rigid->isActive()));
    }
}

void BulletEngine::debug_lines(std::vector<DebugLine>& out, const DebugDraw& draw) {
    for (size_t i = 0; draw.hulls && i < bodies_.size(); ++i) {
        const BulletBody& body = *bodies_[i];
        for (size_t part = 0; part < body.hulls.size(); ++part) {
            btTransform frame = body.rigid->getWorldTransform();
            if (body.compound) frame = frame * body.compound->getChildTransform(static_cast<int>(part));
            std::vector<glm::vec3> points;
            for (int p = 0; p < body.hulls[part]->getNumPoints(); ++p)
                points.push_back(metres_from_bullet(frame * body.hulls[part]->getUnscaledPoints()[p]));
            for (const auto& [from, to] : hull_edges(points))
                out.push_back({points[from], points[to], hull_colour(awake(i))});
        }
    }
    for (const auto& joint : joints_) {
        if (!draw.joints) break;
        const auto frame = [](const BulletBody* body) {
            return body ? body->rigid->getWorldTransform() : btTransform::getIdentity();
        };
        const glm::vec3 a = metres_from_bullet(frame(joint->a) * joint->in_a);
        const glm::vec3 axis = to_glm(frame(joint->a).getBasis() * joint->axis);
        out.push_back({a,
                       joint->kind == JointKind::hinge ? a + axis * joint_axis_length
                                                       : metres_from_bullet(frame(joint->b) * joint->in_b),
                       joint_colour});
    }
    if (!draw.contacts) return;
    for_each_manifold([&](const btPersistentManifold& manifold) {
        for (int p = 0; p < manifold.getNumContacts(); ++p) {
            const btManifoldPoint& point = manifold.getContactPoint(p);
            if (point.getDistance() >= touching_distance * units) continue;
            out.push_back(
                contact_line(metres_from_bullet(point.getPositionWorldOnB()), to_glm(point.m_normalWorldOnB)));
        }
    });
}

} // namespace

std::unique_ptr<Engine> make_bullet_engine(const WorldSettings& settings) {
    return std::make_unique<BulletEngine>(settings);
}

} // namespace brittle::physics
