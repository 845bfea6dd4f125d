#include "physics/world.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <ostream>
#include <sstream>
#include <string>
#include <type_traits>
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

// One body. Bullet's frame has the same origin as ours and the principal axes as its own.
struct BodyRecord {
    BodyId id;
    glm::quat to_principal{1.0f, 0.0f, 0.0f, 0.0f}; // body axes = to_principal * principal axes
    glm::dvec3 moments{1.0};                        // principal, kg m^2
    Pose previous;
    float still_seconds = 0.0f; // how long it has been slow while touching something
    bool touching = false;      // in the last step
    std::vector<HullEdge>
        edges; // for debug lines, indices into the shape's points; filled when first asked for
    std::unique_ptr<btConvexHullShape> shape;
    std::unique_ptr<btRigidBody> rigid;

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
        for (const auto& body : bodies_) {
            if (!body->rigid->isActive()) continue;
            const btQuaternion q = body->rigid->getWorldTransform().getRotation();
            spins_.push_back({glm::dquat(to_glm(q)), glm::dvec3(to_glm(body->rigid->getAngularVelocity()))});
        }
        btDiscreteDynamicsWorld::integrateTransforms(seconds);
        size_t next = 0;
        for (const auto& body : bodies_) {
            if (!body->rigid->isActive()) continue;
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
};

// Bullet's solver, with two changes to what it is given.
//
// Contacts with the ground come last, so that each sweep ends with nothing going into the ground. In Bullet's
// own order, a heavy piece presses a light one beneath it millimetres deep and holds it there; what is left
// over now is overlap between the two, inside the pile.
//
// Overlap between bodies counts only as far as may be undone in one step: see
// WorldSettings::separation_speed. The true distances are found anew before the next step.
class PieceSolver final : public btSequentialImpulseConstraintSolver {
  public:
    explicit PieceSolver(const WorldSettings& settings) : separation_speed_(settings.separation_speed) {}

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
        for (auto between = ordered_.begin(); between != ground; ++between)
            for (int i = 0; i < (*between)->getNumContacts(); ++i) {
                btManifoldPoint& point = (*between)->getContactPoint(i);
                point.m_distance1 = std::max(point.m_distance1, deepest);
            }
        return btSequentialImpulseConstraintSolver::solveGroup(bodies, body_count, ordered_.data(),
                                                               manifold_count, constraints, constraint_count,
                                                               info, drawer, dispatcher);
    }

  private:
    float separation_speed_;
    std::vector<btPersistentManifold*> ordered_; // scratch of one call
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
        : solver(settings) {
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

// Reasons why no body can be made of a description; an empty string where there is none.
std::string fault_of(const BodyDesc& desc) {
    if (desc.hull.points.size() < 4)
        return text("its hull has ", desc.hull.points.size(), " points, at least 4 are needed");
    for (size_t i = 0; i < desc.hull.points.size(); ++i)
        if (!finite(desc.hull.points[i])) return text("point ", i, " of its hull is not finite");
    if (!(desc.hull.margin > 0.0f) || !std::isfinite(desc.hull.margin))
        return text("its hull's margin is ", desc.hull.margin, " m, it must be positive");
    if (!(desc.mass >= least_mass && desc.mass <= greatest_mass))
        return text("its mass is ", desc.mass, " kg; it must be between ", least_mass, " and ", greatest_mass,
                    " kg");
    for (int column = 0; column < 3; ++column)
        if (!finite(desc.inertia[column])) return "its inertia tensor is not finite";
    if (!finite(desc.pose.position) || !finite(desc.linear_velocity) || !finite(desc.angular_velocity))
        return "its position or velocity is not finite";
    const float norm = glm::dot(desc.pose.orientation, desc.pose.orientation);
    if (!std::isnormal(norm))
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

struct World::Impl {
    WorldSettings settings;
    std::vector<std::unique_ptr<BodyRecord>>
        bodies;                        // in body order; the rigid bodies' user index points here
    std::vector<BodyId> ids;           // in body order
    std::vector<uint32_t> order_of_id; // by BodyId::value; UINT32_MAX once removed
    std::unique_ptr<Engine> engine;
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
        if (settings.sleeping) body.rigid->forceActivationState(ACTIVE_TAG);
    }
};

Mechanics World::Impl::mechanics_of(const BodyRecord& body) const {
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
    fracture::PrincipalAxes principal = fracture::principal_axes(glm::dmat3(desc.inertia));
    if (const std::string fault = settle_moments(principal.moments); !fault.empty()) return refused(fault);

    auto body = std::make_unique<BodyRecord>();
    body->id = {static_cast<uint32_t>(impl_->order_of_id.size())};
    body->to_principal = glm::normalize(glm::quat(glm::quat_cast(principal.axes)));
    body->moments = principal.moments;
    body->shape = std::make_unique<btConvexHullShape>();
    const glm::quat from_body = glm::conjugate(body->to_principal);
    for (const glm::vec3& point : desc.hull.points)
        body->shape->addPoint(metres_to_bullet(from_body * point), false);
    body->shape->setMargin(desc.hull.margin * bullet_units);
    body->shape->recalcLocalAabb();

    const glm::quat orientation = glm::normalize(desc.pose.orientation);
    const btTransform frame(to_bullet(orientation * body->to_principal),
                            metres_to_bullet(desc.pose.position));
    btRigidBody::btRigidBodyConstructionInfo info(
        desc.mass, nullptr, body->shape.get(), metres_to_bullet(glm::vec3(principal.moments) * bullet_units));
    info.m_startWorldTransform = frame;
    info.m_friction = desc.friction;
    info.m_restitution = desc.restitution;
    info.m_linearDamping = impl_->settings.linear_damping;
    info.m_angularDamping = impl_->settings.angular_damping;
    body->rigid = std::make_unique<btRigidBody>(info);
    body->rigid->setLinearVelocity(metres_to_bullet(desc.linear_velocity));
    body->rigid->setAngularVelocity(to_bullet(desc.angular_velocity));
    body->rigid->setFlags(0); // no gyroscopic term of Bullet's: see rotation.h
    body->rigid->setUserIndex(static_cast<int>(impl_->bodies.size()));
    if (!impl_->settings.sleeping) body->rigid->setActivationState(DISABLE_DEACTIVATION);
    body->previous = body->pose();

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
    impl_->engine->world->stepSimulation(impl_->settings.step, 0); // 0: one step of just that length
    ++impl_->steps;
}

float World::advance(double seconds) {
    const double step_seconds = impl_->settings.step;
    if (std::isfinite(seconds) && seconds > 0.0) impl_->pending_seconds += seconds;
    for (uint32_t taken = 0; taken < impl_->settings.max_substeps && impl_->pending_seconds >= step_seconds;
         ++taken) {
        step();
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
    return impl_->get(id).rigid->getMass();
}
bool World::awake(BodyId id) const {
    return impl_->get(id).rigid->isActive();
}
Mechanics World::mechanics(BodyId id) const {
    return impl_->mechanics_of(impl_->get(id));
}

void World::apply_impulse(BodyId id, glm::vec3 impulse, glm::vec3 point) {
    BodyRecord* body = impl_->find(id);
    assert(body && "no such body in this world");
    assert(finite(impulse) && finite(point));
    impl_->wake(*body);
    body->rigid->applyImpulse(metres_to_bullet(impulse),
                              metres_to_bullet(point) - body->rigid->getCenterOfMassPosition());
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
        std::ranges::count_if(impl_->bodies, [](const auto& body) { return body->rigid->isActive(); }));
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
    for (size_t i = 0; draw.hulls && i < impl_->bodies.size(); ++i) {
        BodyRecord& body = *impl_->bodies[i];
        const btVector3* points = body.shape->getUnscaledPoints();
        if (body.edges.empty()) {
            std::vector<glm::vec3> corners;
            for (int p = 0; p < body.shape->getNumPoints(); ++p) corners.push_back(to_glm(points[p]));
            body.edges = hull_edges(corners);
        }
        const btTransform& frame = body.rigid->getWorldTransform();
        const glm::vec3 colour = body.rigid->isActive() ? awake_colour : asleep_colour;
        for (const auto& [from, to] : body.edges)
            out.push_back(
                {metres_from_bullet(frame * points[from]), metres_from_bullet(frame * points[to]), colour});
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
