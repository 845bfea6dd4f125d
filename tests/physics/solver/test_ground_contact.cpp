// Which bodies are out of the ground's reach, against where their corners are and can get to; which corners have contacts, against a
// look at each; contacts of hulls of a compound.
#include "physics/solver/ground_contact.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <span>
#include <vector>

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <btBulletDynamicsCommon.h>
#include <doctest/doctest.h>

#include "physics/solver/hull_shape.h"
#include "physics/solver/narrow_phase.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

constexpr float step_seconds = 1.0f / 120.0f;

// A hull above the ground, alone or the first of a compound, and its contacts.
class OnGround {
  public:
    OnGround(HullShape& hull, float ground_height, btCompoundShape* compound = nullptr)
        : body(1.0f, nullptr, compound ? static_cast<btCollisionShape*>(compound) : &hull, {1, 1, 1}), hull_(hull),
          index_(compound ? 0 : -1), plane_({0, 1, 0}, ground_height), dispatcher_(&configuration_),
          contacts_(dispatcher_) {
        ground_.setCollisionShape(&plane_);
    }
    ~OnGround() {
        if (!pair_) return;
        pair_->~FollowedContacts();
        dispatcher_.freeCollisionAlgorithm(pair_);
    }
    // Those of a step, where the body is; nothing where there are none.
    GroundManifold* find() {
        const btTransform frame = body.getWorldTransform();
        const btCollisionObjectWrapper hull(nullptr, &hull_, &body, frame, -1, index_);
        const btCollisionObjectWrapper below(nullptr, &plane_, &ground_, ground_.getWorldTransform(), -1, -1);
        if (!pair_)
            pair_ = static_cast<FollowedContacts*>(
                dispatcher_.findAlgorithm(&hull, &below, nullptr, BT_CONTACT_POINT_ALGORITHMS));
        btManifoldResult result(&hull, &below);
        btDispatcherInfo step;
        step.m_timeStep = step_seconds;
        pair_->processCollision(&hull, &below, step, &result);
        std::vector<AnyManifold> found;
        pair_->collect(found);
        return found.empty() ? nullptr : found[0].ground;
    }
    // Those that were found follow the body.
    void refresh() {
        btManifoldResult unused;
        pair_->refresh(unused);
    }

    btRigidBody body;

  private:
    static btDefaultCollisionConstructionInfo sizes() {
        btDefaultCollisionConstructionInfo result;
        result.m_customCollisionAlgorithmMaxElementSize = GroundContacts::pair_size();
        return result;
    }

    HullShape& hull_;
    int index_;
    btStaticPlaneShape plane_;
    btCollisionObject ground_;
    btDefaultCollisionConfiguration configuration_{sizes()};
    btCollisionDispatcher dispatcher_;
    GroundContacts contacts_;
    FollowedContacts* pair_ = nullptr;
};

// A corner of a hull, by itself and in double precision.
struct Corner {
    glm::dvec3 position;             // margin included
    double distance, ahead, reached; // contacts are made below that
    int index;
};

std::vector<Corner> corners_of(const OnGround& on_ground, const HullShape& hull, double ground_height) {
    const auto vector = [](const btVector3& v) { return glm::dvec3(v.x(), v.y(), v.z()); };
    const btRigidBody& body = on_ground.body;
    const glm::dvec3 spin = vector(body.getAngularVelocity());
    const double falling = vector(body.getLinearVelocity()).y + vector(body.getGravity()).y * step_seconds;
    std::vector<Corner> corners;
    for (int i = 0; i < hull.getNumPoints(); ++i) {
        glm::dvec3 arm(0.0); // from the centre of mass, which is the frame's origin
        for (int axis = 0; axis < 3; ++axis)
            arm[axis] =
                glm::dot(vector(body.getWorldTransform().getBasis()[axis]), vector(hull.getUnscaledPoints()[i]));
        glm::dvec3 position = arm + vector(body.getWorldTransform().getOrigin());
        position.y -= static_cast<double>(hull.getMargin());
        const double approach = -(falling + glm::cross(spin, arm).y), distance = position.y - ground_height;
        const double resting = 0.02 * static_cast<double>(hull.getAngularMotionDisc());
        corners.push_back({position, distance, distance - approach * step_seconds,
                           resting + 2.0 * std::max(0.0, approach) * step_seconds, i});
    }
    return corners;
}

// Each in its turn must be the best of those that are left, as far as rounding tells.
void check_choice(std::span<const Corner> chosen, std::vector<Corner> left) {
    const auto take = [&](const Corner& one, const auto& score) {
        std::erase_if(left, [&](const Corner& other) { return other.index == one.index; });
        for (const Corner& other : left) CHECK(score(one) >= score(other) - 1e-3);
    };
    const glm::dvec3 first = chosen[0].position, line = chosen[1].position - first;
    const auto side = [&](const Corner& corner) { return glm::cross(line, corner.position - first).y; };
    const double other_side = side(chosen[2]) > 0.0 ? -1.0 : 1.0;
    take(chosen[0], [](const Corner& corner) { return -corner.ahead; });
    take(chosen[1], [&](const Corner& corner) { return glm::dot(corner.position - first, corner.position - first); });
    take(chosen[2], [&](const Corner& corner) { return std::abs(side(corner)); });
    take(chosen[3], [&](const Corner& corner) { return other_side * side(corner); });
    constexpr double sunk = -1e-4 * 10.0;
    std::erase_if(left, [](const Corner& corner) { return corner.ahead > sunk; });
    for (size_t i = 4; i < chosen.size(); ++i) {
        CHECK(chosen[i].ahead <= sunk + 1e-4);
        take(chosen[i], [&](const Corner& corner) {
            double apart = 1e30;
            for (const Corner& taken : chosen.first(i))
                apart = std::min(apart, glm::dot(corner.position - taken.position, corner.position - taken.position));
            return apart;
        });
    }
    if (chosen.size() < GroundManifold::max_points)
        CHECK(std::ranges::all_of(left, [](const Corner& corner) { return corner.ahead > sunk - 1e-4; }));
}

} // namespace

TEST_CASE("a body is out of the ground's reach only if no corner can come to it in the step, and far above it always") {
    size_t out = 0, within = 0;
    for (uint64_t seed = 0; seed < 4000; ++seed) {
        CAPTURE(seed);
        test::Random random(seed);
        const auto number = [&](double low, double high) { return static_cast<float>(random.uniform(low, high)); };
        const btVector3 sides(number(0.01, 2.0), number(0.01, 2.0), number(0.01, 2.0)); // needles and plates, too
        HullShape hull;
        for (int i = 0; i < 12; ++i)
            hull.addPoint(btVector3(number(-1, 1), number(-1, 1), number(-1, 1)) * sides, false);
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
        const bool is_out = GroundContacts::is_out_of_reach(body, *ground, step_seconds);
        ++(is_out ? out : within);
        // Every way that a corner can take in the step.
        float lowest = 1e9f;
        for (int i = 0; i < hull.getNumPoints(); ++i) {
            const btVector3 arm = frame.getBasis() * hull.getUnscaledPoints()[i];
            const float turning = body.getAngularVelocity().length() * (arm.length() + hull.getMargin()) * step_seconds;
            const float falling = std::min(0.0f, (body.getLinearVelocity().y() - 98.1f * step_seconds) * step_seconds);
            lowest = std::min(lowest,
                              frame.getOrigin().y() + arm.y() - hull.getMargin() - turning + falling - ground_height);
        }
        if (is_out) CHECK(lowest > 0.0f);
        frame.getOrigin().setY(ground_height + 1000.0f);
        body.setWorldTransform(frame);
        CHECK(GroundContacts::is_out_of_reach(body, *ground, step_seconds));
    }
    CHECK(out > 500);
    CHECK(within > 500);
}

TEST_CASE("contacts of a compound's hull with the ground follow it while it moves little, and go when it has gone far "
          "or up") {
    HullShape cube;
    for (int i = 0; i < 8; ++i)
        cube.addPoint({i & 1 ? 5.0f : -5.0f, i & 2 ? 5.0f : -5.0f, i & 4 ? 5.0f : -5.0f}, false);
    cube.setMargin(0.0f);
    cube.finish();
    btCompoundShape compound;
    compound.addChildShape(btTransform::getIdentity(), &cube);
    // What is left of four contacts when the body has moved and turned since they were found.
    const auto left_after = [&](const btVector3& way, float angle) {
        OnGround on_ground(cube, 0.0f, &compound);
        const btVector3 at(3.0f, 5.0f, -2.0f);
        on_ground.body.setWorldTransform(btTransform(btQuaternion::getIdentity(), at));
        const GroundManifold* const found = on_ground.find();
        REQUIRE(found);
        REQUIRE(found->count == 4);
        on_ground.body.setWorldTransform(btTransform(btQuaternion({0, 0, 1}, angle), at + way));
        on_ground.refresh();
        return found->count;
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

TEST_CASE("corners that touch the ground or may come to it have contacts: four that carry, and those that would sink") {
    size_t none = 0, few = 0, some = 0, most = 0;
    for (uint64_t seed = 0; seed < 3000; ++seed) {
        CAPTURE(seed);
        test::Random random(seed);
        const auto number = [&](double low, double high) { return static_cast<float>(random.uniform(low, high)); };
        HullShape hull;
        const int count = 4 + static_cast<int>(random.uniform(0.0, 30.0));
        const btVector3 sides(number(0.2, 4.0), number(0.05, 1.0), number(0.2, 4.0)); // rods and plates, too
        for (int i = 0; i < count; ++i)
            hull.addPoint(btVector3(number(-1, 1), number(-1, 1), number(-1, 1)) * sides, false);
        hull.setMargin(number(0.0, 0.1));
        hull.finish();
        const float ground_height = number(-3.0, 3.0);
        OnGround on_ground(hull, ground_height);
        btRigidBody& body = on_ground.body;
        btTransform frame(btQuaternion(btVector3(number(-1, 1), 0.5f, number(-1, 1)).normalized(), number(-3, 3)),
                          {number(-9, 9), 0.0f, number(-9, 9)});
        frame.getOrigin().setY(ground_height + hull.getMargin() + hull.reach(-frame.getBasis()[1]) + number(-1.0, 0.3));
        body.setWorldTransform(frame);
        body.setGravity({0.0f, -98.1f, 0.0f});
        body.setLinearVelocity({number(-9, 9), number(-9, 3), number(-9, 9)});
        body.setAngularVelocity({number(-20, 20), number(-20, 20), number(-20, 20)});

        const std::vector<Corner> all = corners_of(on_ground, hull, static_cast<double>(ground_height));
        if (std::ranges::any_of(all,
                                [](const Corner& corner) { return std::abs(corner.distance - corner.reached) < 1e-4; }))
            continue;
        std::vector<Corner> low, chosen;
        std::ranges::copy_if(all, std::back_inserter(low),
                             [](const Corner& corner) { return corner.distance < corner.reached; });
        const GroundManifold* const found = on_ground.find();
        const std::span<const GroundPoint> points = found ? found->points() : std::span<const GroundPoint>();
        for (const GroundPoint& point : points) {
            const auto same = std::ranges::find(low, point.corner, &Corner::index);
            REQUIRE(same != low.end());
            CHECK(std::ranges::count(points, point.corner, &GroundPoint::corner) == 1);
            CHECK(std::abs(static_cast<double>(point.distance) - same->distance) < 1e-4);
            for (int axis = 0; axis < 3; ++axis)
                CHECK(std::abs(static_cast<double>(point.position[static_cast<size_t>(axis)]) - same->position[axis])
                      < 1e-4);
            chosen.push_back(*same);
        }
        ++(low.empty() ? none : low.size() <= 4 ? few : chosen.size() < GroundManifold::max_points ? some : most);
        CHECK(chosen.size() >= std::min<size_t>(low.size(), 4));
        if (low.size() > 4) check_choice(chosen, low);

        frame.getOrigin() += btVector3(0.0f, 50.0f, 0.0f);
        body.setWorldTransform(frame);
        CHECK(on_ground.find() == nullptr);
    }
    for (const size_t enough : {none, few, some, most}) CHECK(enough > 100);
}

TEST_CASE("a corner that stays a contact keeps its impulses, and one that takes its place has none") {
    HullShape drum; // two rings of eight
    for (int i = 0; i < 16; ++i) {
        const float angle = static_cast<float>(i / 2) * SIMD_PI / 4.0f;
        drum.addPoint({i % 2 == 0 ? -3.0f : 3.0f, 2.0f * std::cos(angle), 2.0f * std::sin(angle)}, false);
    }
    drum.setMargin(0.0f);
    drum.finish();
    OnGround on_ground(drum, 0.0f);
    size_t kept = 0, fresh = 0;
    std::vector<GroundPoint> before;
    for (int turn = 0; turn < 24; ++turn) { // it rolls, a third of a side at a time
        CAPTURE(turn);
        const btMatrix3x3 turned(btQuaternion({1, 0, 0}, static_cast<float>(turn) * SIMD_PI / 12.0f));
        on_ground.body.setWorldTransform(btTransform(turned, {0.0f, drum.reach(-turned[1]), 0.0f}));
        GroundManifold* const found = on_ground.find();
        REQUIRE(found);
        for (GroundPoint& point : found->points()) {
            const auto same = std::ranges::find(before, point.corner, &GroundPoint::corner);
            const bool known = same != before.end();
            ++(known ? kept : fresh);
            CHECK(point.speed == 0.0f);
            CHECK(!point.blow);
            CHECK(point.impulse == (known ? same->kept_impulse() : 0.0f));
            CHECK(point.friction == (known ? same->kept_friction() : 0.0f));
            CHECK(point.along == (known ? same->along : std::array<float, 3>{}));
            // As a solution leaves it.
            const auto mark = static_cast<float>(point.corner + 100 * turn + 1);
            point.speed = mark;
            point.impulse = 2.0f * mark;
            point.friction = 3.0f * mark;
            point.along = {mark, 0.0f, -mark};
            point.blow = (point.corner + turn) % 5 == 0;
        }
        before.assign(found->points().begin(), found->points().end());
    }
    CHECK(kept > 20);
    CHECK(fresh >= 16); // each corner comes down once
}
