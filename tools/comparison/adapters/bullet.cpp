// Debian's Bullet for tools/compare --physics, as its manual and its examples use it: a btDiscreteDynamicsWorld with the
// solver's defaults, and convex hulls that are smaller by their margin, as in Bullet's fracture example.
#include <memory>

#include <LinearMath/btConvexHullComputer.h>
#include <btBulletDynamicsCommon.h>

#include "tools/comparison/adapters/physics.h"

namespace brittle::comparison {

namespace {

// Upper bound of the margin as a share of the distance from the middle of a hull to its nearest face: a tenth of
// half the thickness, as of Bullet's own shapes (btConvexInternalShape::setSafeMargin).
constexpr btScalar max_margin_share = 0.1f;

btScalar scalar(double value) {
    return static_cast<btScalar>(value);
}
btVector3 vector_of(const Numbers3& p) {
    return {scalar(p[0]), scalar(p[1]), scalar(p[2])};
}

// Bullet adds the margin around the points, so each face moves inwards by it.
std::unique_ptr<btConvexHullShape> hull_of(const std::vector<Numbers3>& corners) {
    btConvexHullComputer computer;
    const btScalar margin = computer.compute(corners[0].data(), sizeof(Numbers3), static_cast<int>(corners.size()),
                                             CONVEX_DISTANCE_MARGIN, max_margin_share);
    if (margin < 0 || computer.vertices.size() < 4) throw std::runtime_error("Bullet makes no hull of a body");
    auto shape = std::make_unique<btConvexHullShape>();
    for (int k = 0; k < computer.vertices.size(); ++k) shape->addPoint(computer.vertices[k], false);
    shape->setMargin(margin);
    shape->recalcLocalAabb();
    return shape;
}

struct Simulation {
    Simulation(const RigidScene& scene, const std::vector<std::string>&) : step_seconds(scalar(scene.numbers.step)) {
        world.setGravity(vector_of(scene.numbers.gravity));
        if (scene.ground) {
            shapes.push_back(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)));
            add({.friction = scene.numbers.ground_friction, .restitution = scene.numbers.ground_restitution}, true);
        }
        ground = bodies.size();
        for (const RigidBody& body : scene.bodies) {
            shapes.push_back(hull_of(body.corners));
            add(body.numbers, body.fixed);
        }
    }
    ~Simulation() {
        for (const auto& body : bodies) world.removeRigidBody(body.get());
    }

    // A body of the last shape.
    void add(const BodyNumbers& numbers, bool fixed) {
        btRigidBody::btRigidBodyConstructionInfo info(fixed ? btScalar(0) : scalar(numbers.mass), nullptr,
                                                      shapes.back().get(),
                                                      fixed ? btVector3(0, 0, 0) : vector_of(numbers.moments));
        const Numbers4& turn = numbers.pose.orientation;
        info.m_startWorldTransform =
            btTransform(btQuaternion(scalar(turn[0]), scalar(turn[1]), scalar(turn[2]), scalar(turn[3])),
                        vector_of(numbers.pose.position));
        info.m_friction = scalar(numbers.friction);
        info.m_restitution = scalar(numbers.restitution);
        auto body = std::make_unique<btRigidBody>(info);
        body->setLinearVelocity(vector_of(numbers.velocity));
        body->setAngularVelocity(vector_of(numbers.angular_velocity));
        if (!fixed) body->setActivationState(DISABLE_DEACTIVATION);
        world.addRigidBody(body.get());
        bodies.push_back(std::move(body));
    }

    void step() { world.stepSimulation(step_seconds, 0); }
    [[nodiscard]] BodyPose pose(size_t body) const {
        const btTransform& at = bodies[ground + body]->getWorldTransform();
        const btQuaternion turn = at.getRotation();
        const btVector3& place = at.getOrigin();
        return {{place.x(), place.y(), place.z()}, {turn.x(), turn.y(), turn.z(), turn.w()}};
    }

    btScalar step_seconds;
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>> bodies; // the ground first, if there is one
    size_t ground = 0;                                // how many bodies it is
};

} // namespace

} // namespace brittle::comparison

int main(int count, char** words) {
    const int version = btGetVersion();
    return brittle::comparison::serve_physics<brittle::comparison::Simulation>(
        count, words, "Bullet " + std::to_string(version / 100) + "." + std::to_string(version % 100));
}
