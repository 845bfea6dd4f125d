#include "physics/world.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <ostream>
#include <sstream>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include <btBulletDynamicsCommon.h>

#include "physics/ground_contact.h"
#include "fracture/principal_axes.h"
#include "physics/rotation.h"

// Bullet's global slack around every box in its broadphase tree; not declared by the umbrella header.
extern btScalar gDbvtMargin;

namespace brittle::physics {

namespace {

using fracture::Error;
using fracture::Status;

// Least ratio of a body's smallest to its largest principal moment. Below it the solver's single-precision
// rows for spins about the needle's own axis blow up before anything else does.
constexpr double least_moment_ratio = 1e-4;
// What single precision can hold with products and inverses to spare: from a grain of dust to a mountain.
constexpr float least_mass = 1e-18f, greatest_mass = 1e18f;    // kg
constexpr double least_moment = 1e-28, greatest_moment = 1e28; // kg m^2
// How much of its velocity a body keeps per second while it settles: half a second of it takes jitter to
// nothing.
constexpr float settling_kept_per_second = 1e-6f;
// A settling body that trembles above the sleeping speeds, but not by this factor, waits longer instead of
// anew.
constexpr float tremble_factor = 4.0f;
// Waiting counts up to this multiple of the sleeping time, so that a tremble does not at once wake a body
// that waits for its neighbours.
constexpr float patience = 1.5f;
// Slack for "none above the sum of the other two" when moments were rounded to float.
constexpr double moment_slack = 1e-3;
// Contact points further apart than this, in metres, are near but not touching.
constexpr float touching_distance = 1e-3f;
constexpr float contact_line_length = 0.05f; // m
// The ball that is swept for a continuous body, as a part of the largest around the centre that fits into its box: small
// enough not to touch what the body slides along.
constexpr float swept_part = 0.8f;

// Bullet counts in decimetres here. Its tolerances are made for bodies of metres (its GJK takes points of
// less than a centimetre apart for one): in metres, pieces of that size find wrong contacts and creep apart.
constexpr float bullet_units = 10.0f; // per metre

// Axes, angular velocities.
btVector3 to_bullet(const glm::vec3& v) {
    return {v.x, v.y, v.z};
}
// Positions, velocities, accelerations, impulses: whatever has one metre in it.
btVector3 metres_to_bullet(const glm::vec3& v) {
    return to_bullet(v * bullet_units);
}
btQuaternion to_bullet(const glm::quat& q) {
    return {q.x, q.y, q.z, q.w};
}
glm::vec3 to_glm(const btVector3& v) {
    return {v.x(), v.y(), v.z()};
}
glm::vec3 metres_from_bullet(const btVector3& v) {
    return to_glm(v) / bullet_units;
}
glm::quat to_glm(const btQuaternion& q) {
    return {q.w(), q.x(), q.y(), q.z()};
}
bool finite(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

template<class... Parts>
std::string text(const Parts&... parts) {
    std::ostringstream stream;
    (stream << ... << parts);
    return stream.str();
}

Error bad_setting(std::string message) {
    return {Status::invalid_setting, std::move(message)};
}

// A hull that bodies may share: Bullet's copy in the hull's own axes.
struct SharedShape {
    std::shared_ptr<const CollisionHull> hull;
    btConvexHullShape shape;
    std::vector<HullEdge> edges; // for debug lines; filled when first asked for
};

// One body. Bullet's frame has the same origin as ours and the principal axes as its own.
struct BodyRecord {
    BodyId id;
    glm::quat to_principal{1.0f, 0.0f, 0.0f, 0.0f}; // body axes = to_principal * principal axes
    glm::dvec3 moments{1.0};                        // principal, kg m^2
    float mass = 0.0f;                              // kg, as given
    bool fixed = false;
    float swept_radius = 0.0f; // Bullet's units; 0: not continuous
    Pose previous;
    float still_seconds = 0.0f; // how long it has been slow while touching something
    bool touching = false;      // in the last step
    std::vector<HullEdge> edges; // for debug lines, indices into the points of shape; filled when first asked for
    std::unique_ptr<btConvexHullShape> shape;         // of a body with one hull; null for a compound
    std::vector<std::shared_ptr<SharedShape>> shared; // of a compound, in the order of its parts
    std::unique_ptr<btCompoundShape> compound;        // null for a body with one hull
    std::unique_ptr<btRigidBody> rigid;

    [[nodiscard]] btCollisionShape* collision_shape() const {
        return compound ? static_cast<btCollisionShape*>(compound.get()) : shape.get();
    }

    [[nodiscard]] bool awake() const { return !fixed && rigid->isActive(); }
    [[nodiscard]] Pose pose() const {
        const btTransform& frame = rigid->getWorldTransform();
        return {metres_from_bullet(frame.getOrigin()),
                to_glm(frame.getRotation()) * glm::conjugate(to_principal)};
    }
};

// Bullet's world with two of its parts replaced: the rotation of free bodies and the rule for falling asleep.
class SteppedWorld final : public btDiscreteDynamicsWorld {
  public:
    SteppedWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase, btConstraintSolver* solver,
                 btCollisionConfiguration* configuration, const WorldSettings& settings,
                 const std::vector<std::unique_ptr<BodyRecord>>& bodies)
        : btDiscreteDynamicsWorld(dispatcher, broadphase, solver, configuration), settings_(settings),
          bodies_(bodies) {}

  protected:
    // Orientation and angular velocity of Bullet's own integration are replaced; see rotation.h.
    void integrateTransforms(btScalar seconds) override {
        spins_.clear();
        shortened_.clear();
        for (const auto& body : bodies_) {
            if (!body->awake()) continue;
            const btQuaternion q = body->rigid->getWorldTransform().getRotation();
            spins_.push_back({glm::dquat(to_glm(q)), glm::dvec3(to_glm(body->rigid->getAngularVelocity()))});
            if (body->swept_radius > 0.0f) stop_at_hit(*body->rigid, body->swept_radius, seconds);
        }
        btDiscreteDynamicsWorld::integrateTransforms(seconds);
        for (const auto& [rigid, velocity] : shortened_) rigid->setLinearVelocity(velocity);
        size_t next = 0;
        for (const auto& body : bodies_) {
            if (!body->awake()) continue;
            const Spin spin = free_spin(spins_[next++], body->moments, seconds);
            btTransform frame = body->rigid->getWorldTransform();
            frame.setRotation(to_bullet(glm::quat(spin.orientation)));
            body->rigid->setWorldTransform(frame);
            body->rigid->updateInertiaTensor();
            body->rigid->setAngularVelocity(to_bullet(glm::vec3(spin.velocity)));
        }
    }

    // Bullet lets a body sleep when it is slower than 0.8 m/s for two seconds, wherever it is, and lets piles
    // jitter for ever. Here it must touch something, be really slow, and is damped on its way to rest. That
    // islands sleep and wake as a whole remains Bullet's.
    void updateActivationState(btScalar seconds) override {
        if (!settings_.sleeping) return;
        find_touching();
        const float kept = std::pow(settling_kept_per_second, seconds);
        for (const auto& body : bodies_) {
            btRigidBody& rigid = *body->rigid;
            if (body->fixed) continue;
            if (rigid.getActivationState() == ISLAND_SLEEPING) {
                rigid.setLinearVelocity({0, 0, 0});
                rigid.setAngularVelocity({0, 0, 0});
                continue;
            }
            const float speed =
                std::max(rigid.getLinearVelocity().length() / (settings_.sleep_linear_speed * bullet_units),
                         rigid.getAngularVelocity().length() / settings_.sleep_angular_speed);
            // One tremble that is soon over does not start the wait anew.
            if (!body->touching || speed > tremble_factor)
                body->still_seconds = 0.0f;
            else
                body->still_seconds = std::clamp(body->still_seconds + (speed < 1.0f ? seconds : -seconds),
                                                 0.0f, patience * settings_.sleep_seconds);
            if (body->still_seconds > 0.5f * settings_.sleep_seconds) {
                rigid.setLinearVelocity(rigid.getLinearVelocity() * kept);
                rigid.setAngularVelocity(rigid.getAngularVelocity() * kept);
            }
            rigid.setActivationState(body->still_seconds >= settings_.sleep_seconds ? WANTS_DEACTIVATION
                                                                                    : ACTIVE_TAG);
        }
    }

  private:
    // The nearest body that a ball runs into; not itself and not the ground, which has contacts of its own that
    // look ahead.
    struct FirstHit final : ClosestConvexResultCallback {
        FirstHit(const btRigidBody& mover, const btVector3& from, const btVector3& to, btScalar ball_radius)
            : ClosestConvexResultCallback(from, to), body(mover), path(to - from), radius(ball_radius) {}
        bool needsCollision(btBroadphaseProxy* proxy) const override {
            const auto* object = static_cast<const btCollisionObject*>(proxy->m_clientObject);
            return object != &body && object->getUserIndex() >= 0
                   && ClosestConvexResultCallback::needsCollision(proxy);
        }
        btScalar addSingleResult(btCollisionWorld::LocalConvexResult& result, bool in_world) override {
            // On its way out, or sliding along: too slow towards it to get through in one step.
            if (result.m_hitNormalLocal.dot(path) > -radius) return m_closestHitFraction;
            return ClosestConvexResultCallback::addSingleResult(result, in_world);
        }
        const btRigidBody& body;
        btVector3 path;
        btScalar radius;
    };

    // Bullet's own sweep knows bodies of one hull only. The body's velocity is made such that the coming integration
    // ends at the first hit; shortened_ remembers the true one.
    void stop_at_hit(btRigidBody& rigid, btScalar radius, btScalar seconds) {
        const btVector3 velocity = rigid.getLinearVelocity();
        if (velocity.length() * seconds <= radius) return;
        btTransform from = rigid.getWorldTransform(), to = from;
        to.setOrigin(from.getOrigin() + velocity * seconds);
        FirstHit hit(rigid, from.getOrigin(), to.getOrigin(), radius);
        btSphereShape ball(radius);
        convexSweepTest(&ball, from, to, hit, getDispatchInfo().m_allowedCcdPenetration);
        if (!hit.hasHit()) return;
        shortened_.emplace_back(&rigid, velocity);
        rigid.setLinearVelocity(velocity * hit.m_closestHitFraction);
    }

    void find_touching() {
        for (const auto& body : bodies_) body->touching = false;
        for (int i = 0; i < getDispatcher()->getNumManifolds(); ++i) {
            const btPersistentManifold* manifold = getDispatcher()->getManifoldByIndexInternal(i);
            if (manifold->getNumContacts() == 0) continue;
            for (const btCollisionObject* object : {manifold->getBody0(), manifold->getBody1()})
                if (object->getUserIndex() >= 0)
                    bodies_[static_cast<size_t>(object->getUserIndex())]->touching = true;
        }
    }

    const WorldSettings& settings_;
    const std::vector<std::unique_ptr<BodyRecord>>& bodies_;
    std::vector<Spin> spins_; // scratch of one step
    std::vector<std::pair<btRigidBody*, btVector3>> shortened_; // likewise: velocities of bodies that stop at a hit
};

// Bullet's solver, with two changes to what it is given, and a report of what it did.
//
// Contacts with the ground and with fixed bodies come last, so that each sweep ends with nothing going into the
// ground. In Bullet's own order, a heavy piece presses a light one beneath it millimetres deep and holds it there;
// what is left over now is overlap between the two, inside the pile.
//
// Overlap between bodies counts only as far as may be undone in one step: see
// WorldSettings::separation_speed. The true distances are found anew before the next step.
class PieceSolver final : public btSequentialImpulseConstraintSolver {
  public:
    PieceSolver(const WorldSettings& settings, const std::vector<std::unique_ptr<BodyRecord>>& bodies)
        : separation_speed_(settings.separation_speed), bodies_(bodies) {}

    std::vector<Contact> contacts; // of this step, appended by each call

    btScalar solveGroup(btCollisionObject** bodies, int body_count, btPersistentManifold** manifolds,
                        int manifold_count, btTypedConstraint** constraints, int constraint_count,
                        const btContactSolverInfo& info, btIDebugDraw* drawer,
                        btDispatcher* dispatcher) override {
        ordered_.assign(manifolds, manifolds + manifold_count);
        const auto ground =
            std::stable_partition(ordered_.begin(), ordered_.end(), [](const btPersistentManifold* manifold) {
                return !manifold->getBody0()->isStaticObject() && !manifold->getBody1()->isStaticObject();
            });
        const btScalar deepest = -separation_speed_ * bullet_units * info.m_timeStep / info.m_erp2;
        for (auto between = ordered_.begin(); between != ordered_.end(); ++between) {
            if (between >= ground && on_ground(**between)) continue;
            for (int i = 0; i < (*between)->getNumContacts(); ++i) {
                btManifoldPoint& point = (*between)->getContactPoint(i);
                point.m_distance1 = std::max(point.m_distance1, deepest);
            }
        }
        note_speeds();
        const btScalar result = btSequentialImpulseConstraintSolver::solveGroup(
            bodies, body_count, ordered_.data(), manifold_count, constraints, constraint_count, info, drawer,
            dispatcher);
        report_contacts();
        return result;
    }

    // Of bodies that sleep, which nobody solves: what they pressed when they last were awake.
    void report_sleeping(btDispatcher& dispatcher) {
        const auto rests = [](const btCollisionObject& object) {
            return object.isStaticObject() || !object.isActive();
        };
        for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
            const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
            if (!rests(*manifold.getBody0()) || !rests(*manifold.getBody1())) continue;
            for (int p = 0; p < manifold.getNumContacts(); ++p)
                if (manifold.getContactPoint(p).m_appliedImpulse > 0.0f)
                    contacts.push_back(contact_of(manifold, manifold.getContactPoint(p), 0.0f));
        }
    }

  private:
    static bool on_ground(const btPersistentManifold& manifold) {
        return manifold.getBody0()->getUserIndex() < 0 || manifold.getBody1()->getUserIndex() < 0;
    }
    static btVector3 velocity_at(const btCollisionObject& object, const btVector3& point) {
        const btRigidBody& rigid = *btRigidBody::upcast(&object);
        return rigid.getVelocityInLocalPoint(point - rigid.getCenterOfMassPosition());
    }
    void note_speeds() {
        speeds_.clear();
        for (const btPersistentManifold* manifold : ordered_)
            for (int i = 0; i < manifold->getNumContacts(); ++i) {
                const btManifoldPoint& point = manifold->getContactPoint(i);
                const btVector3 apart = velocity_at(*manifold->getBody0(), point.getPositionWorldOnA())
                                        - velocity_at(*manifold->getBody1(), point.getPositionWorldOnB());
                speeds_.push_back(-apart.dot(point.m_normalWorldOnB) / bullet_units);
            }
    }
    void report_contacts() {
        size_t next = 0;
        for (const btPersistentManifold* manifold : ordered_)
            for (int i = 0; i < manifold->getNumContacts(); ++i) {
                const btManifoldPoint& point = manifold->getContactPoint(i);
                const float speed = speeds_[next++];
                if (point.m_appliedImpulse > 0.0f) contacts.push_back(contact_of(*manifold, point, speed));
            }
    }
    [[nodiscard]] Contact contact_of(const btPersistentManifold& manifold, const btManifoldPoint& point,
                                     float speed) const {
        Contact contact;
        const int first = manifold.getBody0()->getUserIndex(), second = manifold.getBody1()->getUserIndex();
        // Bullet's index is that of the hull in a compound, -1 without; ground_contact.cpp needs it itself.
        const int part_a = on_ground(manifold) ? point.m_partId0 : point.m_index0;
        if (first >= 0) contact.a = bodies_[static_cast<size_t>(first)]->id;
        if (second >= 0) contact.b = bodies_[static_cast<size_t>(second)]->id;
        contact.part_a = static_cast<uint32_t>(std::max(part_a, 0));
        contact.part_b = second >= 0 ? static_cast<uint32_t>(std::max(point.m_index1, 0)) : 0;
        contact.point = metres_from_bullet(point.getPositionWorldOnB());
        contact.normal = to_glm(point.m_normalWorldOnB);
        contact.impulse = point.m_appliedImpulse / bullet_units;
        contact.friction = metres_from_bullet(point.m_lateralFrictionDir1 * point.m_appliedImpulseLateral1);
        contact.speed = speed;
        return contact;
    }

    float separation_speed_;
    const std::vector<std::unique_ptr<BodyRecord>>& bodies_;
    std::vector<btPersistentManifold*> ordered_; // scratch of one call
    std::vector<float> speeds_;                  // likewise: m/s, of all points of ordered_
};

// Everything of Bullet's that a history can hide in; made anew by clear().
struct Engine {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    GroundContacts ground_contacts{dispatcher};
    btDbvtBroadphase broadphase;
    PieceSolver solver;
    std::unique_ptr<SteppedWorld> world;
    std::unique_ptr<btStaticPlaneShape> ground_shape;
    std::unique_ptr<btRigidBody> ground;

    Engine(const WorldSettings& settings, const std::vector<std::unique_ptr<BodyRecord>>& bodies)
        : solver(settings, bodies) {
        world = std::make_unique<SteppedWorld>(&dispatcher, &broadphase, &solver, &configuration, settings,
                                               bodies);
        world->setGravity(metres_to_bullet(settings.gravity));
        world->setForceUpdateAllAabbs(false); // the boxes of sleeping bodies do not change
        btContactSolverInfo& info = world->getSolverInfo();
        info.m_numIterations = static_cast<int>(settings.solver_iterations);
        // Overlap is resolved by moving bodies, never by accelerating them, however shallow: otherwise the
        // repair of an overlap turns into kinetic energy.
        info.m_splitImpulse = 1;
        info.m_splitImpulsePenetrationThreshold = 0.0f;
        info.m_restitutionVelocityThreshold *= bullet_units;
        if (!settings.ground_height) return;
        ground_shape =
            std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), *settings.ground_height * bullet_units);
        btRigidBody::btRigidBodyConstructionInfo ground_info(0.0f, nullptr, ground_shape.get());
        ground_info.m_friction = settings.ground_friction;
        ground_info.m_restitution = settings.ground_restitution;
        ground = std::make_unique<btRigidBody>(ground_info);
        ground->setUserIndex(-1);
        world->addRigidBody(ground.get());
    }

    ~Engine() {
        if (ground) world->removeRigidBody(ground.get());
    }
};

std::string fault_of(const CollisionHull& hull) {
    if (hull.points.size() < 4)
        return text("its hull has ", hull.points.size(), " points, at least 4 are needed");
    for (size_t i = 0; i < hull.points.size(); ++i)
        if (!finite(hull.points[i])) return text("point ", i, " of its hull is not finite");
    if (!(hull.margin > 0.0f) || !std::isfinite(hull.margin))
        return text("its hull's margin is ", hull.margin, " m, it must be positive");
    return {};
}

std::string fault_of(std::span<const BodyPart> parts) {
    for (size_t i = 0; i < parts.size(); ++i) {
        if (!parts[i].hull) return text("its part ", i, " has no hull");
        if (!finite(parts[i].offset)) return text("the offset of its part ", i, " is not finite");
        if (const std::string fault = fault_of(*parts[i].hull); !fault.empty())
            return text("part ", i, ": ", fault);
    }
    return {};
}

// Reasons why no body can be made of a description; an empty string where there is none.
std::string fault_of(const BodyDesc& desc) {
    if (std::string fault = desc.parts.empty() ? fault_of(desc.hull) : fault_of(desc.parts); !fault.empty())
        return fault;
    if (!(desc.mass >= least_mass && desc.mass <= greatest_mass))
        return text("its mass is ", desc.mass, " kg; it must be between ", least_mass, " and ", greatest_mass,
                    " kg");
    for (int column = 0; column < 3 && !desc.fixed; ++column)
        if (!finite(desc.inertia[column])) return "its inertia tensor is not finite";
    if (!finite(desc.pose.position) || !finite(desc.linear_velocity) || !finite(desc.angular_velocity))
        return "its position or velocity is not finite";
    const Pose previous = desc.previous.value_or(desc.pose);
    if (!finite(previous.position)) return "its previous position is not finite";
    if (!std::isnormal(glm::dot(desc.pose.orientation, desc.pose.orientation))
        || !std::isnormal(glm::dot(previous.orientation, previous.orientation)))
        return "its orientation is no rotation (a quaternion of zero or non-finite length)";
    if (!(desc.friction >= 0.0f) || !(desc.restitution >= 0.0f) || !(desc.restitution <= 1.0f)
        || !std::isfinite(desc.friction))
        return text("its friction ", desc.friction, " or restitution ", desc.restitution,
                    " is out of range (0 or more; 0 to 1)");
    return {};
}

// Fault of principal moments, or an empty string; raises those too small for the solver.
std::string settle_moments(glm::dvec3& moments) {
    const double largest = std::max({moments.x, moments.y, moments.z});
    const double smallest = std::min({moments.x, moments.y, moments.z});
    const double sum = moments.x + moments.y + moments.z;
    if (!(largest >= least_moment && largest <= greatest_moment) || smallest < -moment_slack * largest
        || 2.0 * largest > sum * (1.0 + moment_slack))
        return text("no body has the principal moments of inertia ", moments.x, ", ", moments.y, ", ",
                    moments.z, " kg m^2");
    moments = glm::max(moments, glm::dvec3(largest * least_moment_ratio));
    return {};
}

class Hash {
  public:
    void add(float value) {
        uint32_t bits = std::bit_cast<uint32_t>(value);
        for (int byte = 0; byte < 4; ++byte, bits >>= 8)
            value_ = (value_ ^ (bits & 0xffu)) * 0x100000001b3ull;
    }
    void add(const btVector3& v) {
        for (int axis = 0; axis < 3; ++axis) add(v[axis]);
    }
    [[nodiscard]] uint64_t value() const { return value_; }

  private:
    uint64_t value_ = 0xcbf29ce484222325ull;
};

} // namespace

namespace {

// Bullet's frame has the principal axes, so the hull is turned into them.
void make_single(BodyRecord& body, const CollisionHull& hull, const glm::vec3& offset) {
    body.shape = std::make_unique<btConvexHullShape>();
    const glm::quat from_body = glm::conjugate(body.to_principal);
    for (const glm::vec3& point : hull.points)
        body.shape->addPoint(metres_to_bullet(from_body * (point + offset)), false);
    body.shape->setMargin(hull.margin * bullet_units);
    body.shape->recalcLocalAabb();
}

// From the centre of mass to the nearest side of the shape's box, in Bullet's units.
float least_extent(const btCollisionShape& shape) {
    btVector3 low, high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    return std::min({-low.x(), -low.y(), -low.z(), high.x(), high.y(), high.z()});
}

} // namespace

struct World::Impl {
    WorldSettings settings;
    std::vector<std::unique_ptr<BodyRecord>>
        bodies;                        // in body order; the rigid bodies' user index points here
    std::vector<BodyId> ids;           // in body order
    std::vector<uint32_t> order_of_id; // by BodyId::value; UINT32_MAX once removed
    std::unique_ptr<Engine> engine;
    // Hulls that bodies share, by address: an entry holds its hull, so an address in here names one hull.
    std::unordered_map<const CollisionHull*, std::shared_ptr<SharedShape>> shared_shapes;
    size_t shapes_to_keep = 64; // beyond so many, those without a body are let go
    double pending_seconds = 0.0;
    uint64_t steps = 0;

    explicit Impl(const WorldSettings& given) : settings(given) { make_engine(); }
    ~Impl() { drop_bodies(); }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void make_engine() {
        gDbvtMargin = settings.broadphase_margin * bullet_units;
        engine = std::make_unique<Engine>(settings, bodies);
    }
    // Bullet must let go of a body before the body goes.
    void drop_bodies() {
        for (size_t i = bodies.size(); i-- > 0;) engine->world->removeRigidBody(bodies[i]->rigid.get());
        bodies.clear();
        ids.clear();
    }
    std::shared_ptr<SharedShape> shared_shape(const std::shared_ptr<const CollisionHull>& hull);
    void make_compound(BodyRecord& body, std::span<const BodyPart> parts);
    [[nodiscard]] const BodyRecord* find(BodyId id) const {
        if (id.value >= order_of_id.size() || order_of_id[id.value] == UINT32_MAX) return nullptr;
        return bodies[order_of_id[id.value]].get();
    }
    [[nodiscard]] BodyRecord* find(BodyId id) {
        return const_cast<BodyRecord*>(std::as_const(*this).find(id));
    }
    [[nodiscard]] const BodyRecord& get(BodyId id) const {
        const BodyRecord* body = find(id);
        assert(body && "no such body in this world");
        return *body;
    }
    [[nodiscard]] Mechanics mechanics_of(const BodyRecord& body) const;
    void wake(BodyRecord& body) {
        body.still_seconds = 0.0f;
        if (settings.sleeping && !body.fixed) body.rigid->forceActivationState(ACTIVE_TAG);
    }
};

std::shared_ptr<SharedShape> World::Impl::shared_shape(const std::shared_ptr<const CollisionHull>& hull) {
    if (const auto known = shared_shapes.find(hull.get()); known != shared_shapes.end()) return known->second;
    if (shared_shapes.size() >= shapes_to_keep) {
        std::erase_if(shared_shapes, [](const auto& entry) { return entry.second.use_count() == 1; });
        shapes_to_keep = std::max<size_t>(64, 2 * shared_shapes.size());
    }
    auto made = std::make_shared<SharedShape>();
    made->hull = hull;
    for (const glm::vec3& point : hull->points) made->shape.addPoint(metres_to_bullet(point), false);
    made->shape.setMargin(hull->margin * bullet_units);
    made->shape.recalcLocalAabb();
    shared_shapes.emplace(hull.get(), made);
    return made;
}

void World::Impl::make_compound(BodyRecord& body, std::span<const BodyPart> parts) {
    const glm::quat from_body = glm::conjugate(body.to_principal);
    body.compound = std::make_unique<btCompoundShape>(true, static_cast<int>(parts.size()));
    for (const BodyPart& part : parts) {
        body.shared.push_back(shared_shape(part.hull));
        const btTransform frame(to_bullet(from_body), metres_to_bullet(from_body * part.offset));
        body.compound->addChildShape(frame, &body.shared.back()->shape);
    }
}

Mechanics World::Impl::mechanics_of(const BodyRecord& body) const {
    if (body.fixed) return {};
    const btRigidBody& rigid = *body.rigid;
    const double mass = 1.0 / static_cast<double>(rigid.getInvMass());
    const glm::dvec3 position(metres_from_bullet(rigid.getCenterOfMassPosition()));
    const glm::dvec3 velocity(metres_from_bullet(rigid.getLinearVelocity()));
    const glm::dvec3 spin(to_glm(rigid.getAngularVelocity()));
    const glm::dquat orientation = glm::normalize(glm::dquat(to_glm(rigid.getOrientation())));
    const glm::dvec3 own = orientation * (body.moments * (glm::conjugate(orientation) * spin));
    return {.kinetic = 0.5 * (mass * glm::dot(velocity, velocity) + glm::dot(spin, own)),
            .potential = -mass * glm::dot(glm::dvec3(settings.gravity), position),
            .momentum = mass * velocity,
            .angular_momentum = own + glm::cross(position, mass * velocity)};
}

std::ostream& operator<<(std::ostream& stream, BodyId id) {
    return id == BodyId{} ? stream << "body none" : stream << "body " << id.value;
}

Result<void> validate(const WorldSettings& settings) {
    const auto outside = [](const char* field, float value, const char* range) {
        return bad_setting(text("world setting ", field, " is ", value, "; it must be ", range));
    };
    const auto in = [](float value, float low, float high) { return value >= low && value <= high; };
    constexpr float far = 1e6f;
    if (!finite(settings.gravity))
        return bad_setting("world setting gravity has a component that is not finite");
    if (!in(settings.step, 1e-5f, 0.1f)) return outside("step", settings.step, "between 0.00001 and 0.1 s");
    if (settings.max_substeps < 1 || settings.max_substeps > 1000)
        return outside("max_substeps", static_cast<float>(settings.max_substeps), "between 1 and 1000");
    if (settings.solver_iterations < 1 || settings.solver_iterations > 1000)
        return outside("solver_iterations", static_cast<float>(settings.solver_iterations),
                       "between 1 and 1000");
    if (settings.ground_height && !in(*settings.ground_height, -far, far))
        return outside("ground_height", *settings.ground_height, "between -1000000 and 1000000 m");
    if (!in(settings.ground_friction, 0.0f, far))
        return outside("ground_friction", settings.ground_friction, "0 or more");
    if (!in(settings.ground_restitution, 0.0f, 1.0f))
        return outside("ground_restitution", settings.ground_restitution, "between 0 and 1");
    if (!in(settings.linear_damping, 0.0f, 1.0f))
        return outside("linear_damping", settings.linear_damping, "between 0 and 1");
    if (!in(settings.angular_damping, 0.0f, 1.0f))
        return outside("angular_damping", settings.angular_damping, "between 0 and 1");
    if (!in(settings.separation_speed, 0.0f, far))
        return outside("separation_speed", settings.separation_speed, "0 m/s or more");
    if (!in(settings.broadphase_margin, 0.0f, far))
        return outside("broadphase_margin", settings.broadphase_margin, "0 m or more");
    if (!in(settings.sleep_linear_speed, 0.0f, far))
        return outside("sleep_linear_speed", settings.sleep_linear_speed, "0 m/s or more");
    if (!in(settings.sleep_angular_speed, 0.0f, far))
        return outside("sleep_angular_speed", settings.sleep_angular_speed, "0 rad/s or more");
    if (!in(settings.sleep_seconds, 0.0f, far))
        return outside("sleep_seconds", settings.sleep_seconds, "0 s or more");
    return {};
}

World::World(const WorldSettings& settings) {
    assert(validate(settings) && "settings from outside go through validate() first");
    impl_ = std::make_unique<Impl>(settings);
}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

const WorldSettings& World::settings() const {
    return impl_->settings;
}

Result<BodyId> World::add_body(const BodyDesc& desc) {
    const auto refused = [this](const std::string& fault) {
        return bad_setting(text("body ", impl_->order_of_id.size(), " cannot be added: ", fault));
    };
    if (const std::string fault = fault_of(desc); !fault.empty()) return refused(fault);
    fracture::PrincipalAxes principal;
    if (!desc.fixed) {
        principal = fracture::principal_axes(glm::dmat3(desc.inertia));
        if (const std::string fault = settle_moments(principal.moments); !fault.empty()) return refused(fault);
    }

    auto body = std::make_unique<BodyRecord>();
    body->id = {static_cast<uint32_t>(impl_->order_of_id.size())};
    body->to_principal = glm::normalize(glm::quat(glm::quat_cast(principal.axes)));
    body->moments = principal.moments;
    body->mass = desc.mass;
    body->fixed = desc.fixed;
    if (desc.parts.size() > 1)
        impl_->make_compound(*body, desc.parts);
    else if (desc.parts.size() == 1)
        make_single(*body, *desc.parts[0].hull, desc.parts[0].offset);
    else
        make_single(*body, desc.hull, glm::vec3(0.0f));
    if (desc.continuous && !desc.fixed) body->swept_radius = swept_part * least_extent(*body->collision_shape());

    const glm::quat orientation = glm::normalize(desc.pose.orientation);
    const btTransform frame(to_bullet(orientation * body->to_principal),
                            metres_to_bullet(desc.pose.position));
    btRigidBody::btRigidBodyConstructionInfo info(
        desc.fixed ? 0.0f : desc.mass, nullptr, body->collision_shape(),
        desc.fixed ? btVector3(0, 0, 0) : metres_to_bullet(glm::vec3(principal.moments) * bullet_units));
    info.m_startWorldTransform = frame;
    info.m_friction = desc.friction;
    info.m_restitution = desc.restitution;
    info.m_linearDamping = impl_->settings.linear_damping;
    info.m_angularDamping = impl_->settings.angular_damping;
    body->rigid = std::make_unique<btRigidBody>(info);
    if (!desc.fixed) {
        body->rigid->setLinearVelocity(metres_to_bullet(desc.linear_velocity));
        body->rigid->setAngularVelocity(to_bullet(desc.angular_velocity));
    }
    body->rigid->setFlags(0); // no gyroscopic term of Bullet's: see rotation.h
    body->rigid->setUserIndex(static_cast<int>(impl_->bodies.size()));
    if (!impl_->settings.sleeping) body->rigid->setActivationState(DISABLE_DEACTIVATION);
    body->previous = body->pose();
    if (desc.previous)
        body->previous = {desc.previous->position, glm::normalize(desc.previous->orientation)};

    gDbvtMargin = impl_->settings.broadphase_margin * bullet_units;
    impl_->engine->world->addRigidBody(body->rigid.get());
    impl_->order_of_id.push_back(static_cast<uint32_t>(impl_->bodies.size()));
    impl_->ids.push_back(body->id);
    impl_->bodies.push_back(std::move(body));
    return impl_->ids.back();
}

bool World::remove_body(BodyId id) {
    BodyRecord* body = impl_->find(id);
    if (!body) return false;
    for (int i = 0; i < impl_->engine->dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold* manifold = impl_->engine->dispatcher.getManifoldByIndexInternal(i);
        const btCollisionObject* first = manifold->getBody0();
        const btCollisionObject* second = manifold->getBody1();
        const btCollisionObject* other = first == body->rigid.get()    ? second
                                         : second == body->rigid.get() ? first
                                                                       : nullptr;
        if (other && other->getUserIndex() >= 0)
            impl_->wake(*impl_->bodies[static_cast<size_t>(other->getUserIndex())]);
    }
    impl_->engine->world->removeRigidBody(body->rigid.get());
    const size_t order = impl_->order_of_id[id.value];
    impl_->bodies.erase(impl_->bodies.begin() + static_cast<std::ptrdiff_t>(order));
    impl_->ids.erase(impl_->ids.begin() + static_cast<std::ptrdiff_t>(order));
    impl_->order_of_id[id.value] = UINT32_MAX;
    for (size_t i = order; i < impl_->bodies.size(); ++i) {
        impl_->bodies[i]->rigid->setUserIndex(static_cast<int>(i));
        impl_->order_of_id[impl_->ids[i].value] = static_cast<uint32_t>(i);
    }
    return true;
}

void World::clear() {
    impl_->drop_bodies();
    std::fill(impl_->order_of_id.begin(), impl_->order_of_id.end(), UINT32_MAX);
    impl_->shared_shapes.clear();
    impl_->pending_seconds = 0.0;
    impl_->steps = 0;
    impl_->make_engine();
}

size_t World::body_count() const {
    return impl_->bodies.size();
}
bool World::contains(BodyId id) const {
    return impl_->find(id) != nullptr;
}
std::span<const BodyId> World::bodies() const {
    return impl_->ids;
}
uint64_t World::steps_taken() const {
    return impl_->steps;
}

void World::step() {
    for (const auto& body : impl_->bodies) body->previous = body->pose();
    gDbvtMargin = impl_->settings.broadphase_margin * bullet_units;
    impl_->engine->solver.contacts.clear();
    impl_->engine->world->stepSimulation(impl_->settings.step, 0); // 0: one step of just that length
    impl_->engine->solver.report_sleeping(impl_->engine->dispatcher);
    ++impl_->steps;
}

float World::advance(double seconds, const std::function<void()>& after_step) {
    const double step_seconds = impl_->settings.step;
    if (std::isfinite(seconds) && seconds > 0.0) impl_->pending_seconds += seconds;
    for (uint32_t taken = 0; taken < impl_->settings.max_substeps && impl_->pending_seconds >= step_seconds;
         ++taken) {
        step();
        if (after_step) after_step();
        impl_->pending_seconds -= step_seconds;
    }
    // What is left over now would only grow from frame to frame: a slow machine gets slow motion, not a
    // standstill.
    if (impl_->pending_seconds >= step_seconds)
        impl_->pending_seconds = std::fmod(impl_->pending_seconds, step_seconds);
    return static_cast<float>(impl_->pending_seconds / step_seconds);
}

size_t World::write_transforms(std::span<Pose> out, float alpha) const {
    const size_t count = std::min(out.size(), impl_->bodies.size());
    for (size_t i = 0; i < count; ++i) {
        const Pose now = impl_->bodies[i]->pose();
        const Pose& before = impl_->bodies[i]->previous;
        out[i] = alpha >= 1.0f ? now
                               : Pose{glm::mix(before.position, now.position, alpha),
                                      glm::slerp(before.orientation, now.orientation, alpha)};
    }
    return count;
}

Pose World::pose(BodyId id) const {
    return impl_->get(id).pose();
}
Pose World::previous_pose(BodyId id) const {
    return impl_->get(id).previous;
}
glm::vec3 World::linear_velocity(BodyId id) const {
    return metres_from_bullet(impl_->get(id).rigid->getLinearVelocity());
}
glm::vec3 World::angular_velocity(BodyId id) const {
    return to_glm(impl_->get(id).rigid->getAngularVelocity());
}
float World::mass(BodyId id) const {
    return impl_->get(id).mass;
}
bool World::fixed(BodyId id) const {
    return impl_->get(id).fixed;
}
bool World::awake(BodyId id) const {
    return impl_->get(id).awake();
}
Mechanics World::mechanics(BodyId id) const {
    return impl_->mechanics_of(impl_->get(id));
}

void World::apply_impulse(BodyId id, glm::vec3 impulse, glm::vec3 point) {
    BodyRecord* body = impl_->find(id);
    assert(body && "no such body in this world");
    assert(finite(impulse) && finite(point));
    if (body->fixed) return;
    impl_->wake(*body);
    body->rigid->applyImpulse(metres_to_bullet(impulse),
                              metres_to_bullet(point) - body->rigid->getCenterOfMassPosition());
}

void World::set_velocity(BodyId id, glm::vec3 linear, glm::vec3 angular) {
    BodyRecord* body = impl_->find(id);
    assert(body && "no such body in this world");
    assert(finite(linear) && finite(angular));
    if (body->fixed) return;
    impl_->wake(*body);
    body->rigid->setLinearVelocity(metres_to_bullet(linear));
    body->rigid->setAngularVelocity(to_bullet(angular));
}

float World::response(BodyId id, glm::vec3 point, glm::vec3 direction) const {
    const BodyRecord& body = impl_->get(id);
    if (body.fixed) return 0.0f;
    return body.rigid->computeImpulseDenominator(metres_to_bullet(point), to_bullet(direction));
}

std::span<const Contact> World::contacts() const {
    return impl_->engine->solver.contacts;
}

void World::wake_all() {
    for (const auto& body : impl_->bodies) impl_->wake(*body);
}

Mechanics World::mechanics() const {
    Mechanics sum;
    for (const auto& body : impl_->bodies) {
        const Mechanics one = impl_->mechanics_of(*body);
        sum.kinetic += one.kinetic;
        sum.potential += one.potential;
        sum.momentum += one.momentum;
        sum.angular_momentum += one.angular_momentum;
    }
    return sum;
}

size_t World::awake_count() const {
    return static_cast<size_t>(
        std::ranges::count_if(impl_->bodies, [](const auto& body) { return body->awake(); }));
}

size_t World::contact_count() const {
    size_t count = 0;
    for (int i = 0; i < impl_->engine->dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold* manifold = impl_->engine->dispatcher.getManifoldByIndexInternal(i);
        for (int point = 0; point < manifold->getNumContacts(); ++point)
            count +=
                manifold->getContactPoint(point).getDistance() < touching_distance * bullet_units ? 1u : 0u;
    }
    return count;
}

uint64_t World::state_hash() const {
    Hash hash;
    for (const auto& body : impl_->bodies) {
        const btTransform& frame = body->rigid->getWorldTransform();
        hash.add(frame.getOrigin());
        for (int row = 0; row < 3; ++row) hash.add(frame.getBasis()[row]);
        hash.add(body->rigid->getLinearVelocity());
        hash.add(body->rigid->getAngularVelocity());
    }
    return hash.value();
}

void World::debug_lines(std::vector<DebugLine>& out, const DebugDraw& draw) const {
    constexpr glm::vec3 awake_colour(1.0f, 0.1f, 0.1f), asleep_colour(0.35f, 0.05f, 0.05f);
    constexpr glm::vec3 contact_colour(1.0f, 0.85f, 0.1f);
    // Not through btIDebugDraw: its wireframe of a convex hull draws every edge twice, from features that it
    // finds anew or keeps in the shape, where they would take part in collisions.
    const auto draw_hull = [&](const btConvexHullShape& shape, std::vector<HullEdge>& edges,
                               const btTransform& frame, const glm::vec3& colour) {
        const btVector3* points = shape.getUnscaledPoints();
        if (edges.empty()) {
            std::vector<glm::vec3> corners;
            for (int p = 0; p < shape.getNumPoints(); ++p) corners.push_back(to_glm(points[p]));
            edges = hull_edges(corners);
        }
        for (const auto& [from, to] : edges)
            out.push_back(
                {metres_from_bullet(frame * points[from]), metres_from_bullet(frame * points[to]), colour});
    };
    for (size_t i = 0; draw.hulls && i < impl_->bodies.size(); ++i) {
        BodyRecord& body = *impl_->bodies[i];
        const btTransform& frame = body.rigid->getWorldTransform();
        const glm::vec3 colour = body.awake() ? awake_colour : asleep_colour;
        if (body.shape) draw_hull(*body.shape, body.edges, frame, colour);
        for (size_t part = 0; part < body.shared.size(); ++part)
            draw_hull(body.shared[part]->shape, body.shared[part]->edges,
                      frame * body.compound->getChildTransform(static_cast<int>(part)), colour);
    }
    for (int i = 0; draw.contacts && i < impl_->engine->dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold* manifold = impl_->engine->dispatcher.getManifoldByIndexInternal(i);
        for (int p = 0; p < manifold->getNumContacts(); ++p) {
            const btManifoldPoint& point = manifold->getContactPoint(p);
            if (point.getDistance() >= touching_distance * bullet_units) continue;
            const glm::vec3 from = metres_from_bullet(point.getPositionWorldOnB());
            const glm::vec3 normal = to_glm(point.m_normalWorldOnB);
            out.push_back({from, from + normal * contact_line_length, contact_colour});
        }
    }
}

} // namespace brittle::physics
