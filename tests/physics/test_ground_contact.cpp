// Which bodies are out of the ground's reach, against where their corners are and can get to; contacts of hulls of a compound.
#include "physics/bullet/ground_contact.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <btBulletDynamicsCommon.h>
#include <doctest/doctest.h>

#include "convex_pieces.h"
#include "physics/bullet/hull_shape.h"
#include "physics/bullet/narrow_phase.h"

using namespace brittle;
using namespace brittle::physics;

TEST_CASE("a body is out of the ground's reach only if no corner can come to it in the step, and far above it always") {
    constexpr float seconds = 1.0f / 120.0f;
    size_t out = 0, within = 0;
    for (uint64_t seed = 0; seed < 4000; ++seed) {
        CAPTURE(seed);
        test::Random random(seed);
        const auto number = [&](double low, double high) { return static_cast<float>(random.uniform(low, high)); };
        const btVector3 sides(number(0.01, 2.0), number(0.01, 2.0), number(0.01, 2.0)); // needles and plates, too
        HullShape hull;
        for (int i = 0; i < 12; ++i) hull.addPoint(btVector3(number(-1, 1), number(-1, 1), number(-1, 1)) * sides, false);
        hull.setMargin(number(0.0, 0.05));
        hull.finish();
        btRigidBody body(1.0f, nullptr, &hull, {1, 1, 1});
        const float ground_height = number(-3.0, 3.0);
        const btStaticPlaneShape plane({0, 1, 0}, ground_height);
        const auto ground = std::make_unique<btCollisionObject>();
        ground->setCollisionShape(const_cast<btStaticPlaneShape*>(&plane));
        btTransform frame(btQuaternion(btVector3(number(-1, 1), 0.5f, number(-1, 1)).normalized(), number(-3, 3)),
                          btVector3(0.0f, ground_height + number(0.0, 12.0), 0.0f));
        body.setWorldTransform(frame);
        body.setLinearVelocity({number(-50, 50), number(-300, 100), number(-50, 50)});
        body.setAngularVelocity({number(-60, 60), number(-60, 60), number(-60, 60)});
        body.setGravity({0.0f, -98.1f, 0.0f});
        const bool is_out = GroundContacts::is_out_of_reach(body, *ground, seconds);
        ++(is_out ? out : within);
        // Every way that a corner can take in the step.
        float lowest = 1e9f;
        for (int i = 0; i < hull.getNumPoints(); ++i) {
            const btVector3 arm = frame.getBasis() * hull.getUnscaledPoints()[i];
            const float turning = body.getAngularVelocity().length() * (arm.length() + hull.getMargin()) * seconds;
            const float falling = std::min(0.0f, (body.getLinearVelocity().y() - 98.1f * seconds) * seconds);
            lowest = std::min(lowest, frame.getOrigin().y() + arm.y() - hull.getMargin() - turning + falling - ground_height);
        }
        if (is_out) CHECK(lowest > 0.0f);
        frame.getOrigin().setY(ground_height + 1000.0f);
        body.setWorldTransform(frame);
        CHECK(GroundContacts::is_out_of_reach(body, *ground, seconds));
    }
    CHECK(out > 500);
    CHECK(within > 500);
}

TEST_CASE("contacts of a compound's hull with the ground follow it while it moves little, and go when it has gone far or up") {
    HullShape cube;
    for (int i = 0; i < 8; ++i) cube.addPoint({i & 1 ? 5.0f : -5.0f, i & 2 ? 5.0f : -5.0f, i & 4 ? 5.0f : -5.0f}, false);
    cube.setMargin(0.0f);
    cube.finish();
    btCompoundShape compound;
    compound.addChildShape(btTransform::getIdentity(), &cube);
    const btStaticPlaneShape plane({0, 1, 0}, 0.0f);
    btRigidBody body(1.0f, nullptr, &compound, {1, 1, 1});
    btCollisionObject ground;
    ground.setCollisionShape(const_cast<btStaticPlaneShape*>(&plane));
    btDefaultCollisionConstructionInfo sizes;
    sizes.m_customCollisionAlgorithmMaxElementSize = GroundContacts::pair_size();
    btDefaultCollisionConfiguration configuration(sizes);
    btCollisionDispatcher dispatcher(&configuration);
    GroundContacts contacts(dispatcher);

    // What is left of four contacts when the body has moved and turned since they were found.
    const auto left_after = [&](const btVector3& way, float angle) {
        body.setWorldTransform(btTransform(btQuaternion::getIdentity(), {3.0f, 5.0f, -2.0f}));
        const btTransform frame = body.getWorldTransform();
        const btCollisionObjectWrapper hull(nullptr, &cube, &body, frame, -1, 0);
        const btCollisionObjectWrapper below(nullptr, &plane, &ground, ground.getWorldTransform(), -1, -1);
        btManifoldResult result(&hull, &below);
        btDispatcherInfo step;
        step.m_timeStep = 1.0f / 120.0f;
        auto* const pair = static_cast<FollowedContacts*>(dispatcher.findAlgorithm(&hull, &below, nullptr, BT_CONTACT_POINT_ALGORITHMS));
        pair->processCollision(&hull, &below, step, &result);
        std::vector<AnyManifold> found;
        pair->collect(found);
        REQUIRE(found.size() == 1);
        REQUIRE(found[0].count() == 4);
        body.setWorldTransform(btTransform(btQuaternion({0, 0, 1}, angle), frame.getOrigin() + way));
        pair->refresh(result);
        const uint32_t left = found[0].count();
        pair->~FollowedContacts();
        dispatcher.freeCollisionAlgorithm(pair);
        return left;
    };
    const float far = 2.0f * cube.getContactBreakingThreshold(gContactBreakingThreshold);
    CHECK(left_after({0.0f, 0.0f, 0.0f}, 0.0f) == 4);
    CHECK(left_after({0.1f * far, 0.0f, 0.1f * far}, 0.0f) == 4);
    CHECK(left_after({0.0f, -far, 0.0f}, 0.0f) == 4); // deeper in the ground
    CHECK(left_after({far, 0.0f, 0.0f}, 0.0f) == 0);
    CHECK(left_after({0.0f, far, 0.0f}, 0.0f) == 0);
    // It tips over its two corners at -X.
    const float turn = 0.2f * far;
    const btVector3 corner(-5.0f, -5.0f, 0.0f);
    CHECK(left_after(corner - corner.rotate({0, 0, 1}, turn), turn) == 2);
}
