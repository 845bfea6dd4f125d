#include <cmath>
#include <limits>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "physics/world/joint.h"
#include "physics/world/world.h"
#include "tests/physics/bodies.h"
#include "tests/physics/joints.h"

using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

// m: how far two bodies are from the places to each other that they had.
class Shape {
  public:
    Shape(const World& world, BodyId a, BodyId b) : a_(a), b_(b), start_(place(world)) {}
    [[nodiscard]] float moved(const World& world) const { return glm::length(place(world).position - start_.position); }
    // rad
    [[nodiscard]] float turned(const World& world) const {
        const glm::quat turn = place(world).orientation * glm::conjugate(start_.orientation);
        return 2.0f * glm::length(glm::vec3(turn.x, turn.y, turn.z));
    }

  private:
    [[nodiscard]] Pose place(const World& world) const {
        const Pose a = world.pose(a_), b = world.pose(b_);
        const glm::quat to_a = glm::conjugate(a.orientation);
        return {to_a * (b.position - a.position), to_a * b.orientation};
    }

    BodyId a_, b_;
    Pose start_;
};

// A box of 10 kg whose middle is half a metre from the origin, along x.
struct Bracket {
    World world{in_vacuum};
    BodyId box;
    static constexpr float weight = 10.0f * g, arm = 0.5f;
    Bracket() { box = must_add(world, test_bodies::box({0.2f, 0.1f, 0.1f}, 10.0f, {arm, 0, 0})); }
    JointId weld(const glm::vec3& at, float max_force = infinity, float max_torque = infinity) {
        return must_join(
            world,
            {.kind = JointKind::fixed, .a = box, .anchor_a = at, .max_force = max_force, .max_torque = max_torque});
    }
    [[nodiscard]] bool holds() {
        const std::vector<JointId> joints(world.joints().begin(), world.joints().end());
        run(world, 0.5f);
        return world.joints().size() == joints.size();
    }
};

} // namespace

TEST_CASE("fixed joints: two bodies in free flight move as one body of both") {
    const glm::vec3 half(0.1f, 0.05f, 0.15f), spin(3.0f, 0.4f, -1.0f), speed(0.3f, -0.2f, 0.1f);
    World world(empty_space), as_one(empty_space);
    // Two boxes side by side along x, and the box of both.
    std::vector<BodyId> halves;
    for (const float side : {-1.0f, 1.0f}) {
        const glm::vec3 place(side * half.x, 0, 0);
        BodyDesc desc = box(half, 2.0f, place);
        // The axes of the second body are others.
        if (side > 0.0f) desc.pose.orientation = glm::angleAxis(0.5f * 3.14159265f, glm::vec3(0, 1, 0));
        if (side > 0.0f) desc.hull = box_hull({half.z, half.y, half.x});
        if (side > 0.0f) desc.inertia = box_inertia({half.z, half.y, half.x}, 2.0f);
        desc.linear_velocity = speed + glm::cross(spin, place);
        desc.angular_velocity = spin;
        halves.push_back(must_add(world, desc));
    }
    BodyDesc whole = box({2.0f * half.x, half.y, half.z}, 4.0f, {0, 0, 0});
    whole.linear_velocity = speed;
    whole.angular_velocity = spin;
    const BodyId one = must_add(as_one, whole);
    must_join(world, {.kind = JointKind::fixed, .a = halves[0], .b = halves[1], .anchor_a = {0, 0.02f, 0.01f}});
    const Shape shape(world, halves[0], halves[1]);
    const Mechanics start = world.mechanics();
    for (int step = 0; step < 240; ++step) {
        world.step();
        as_one.step();
        REQUIRE(shape.moved(world) < 1e-4f);
        REQUIRE(shape.turned(world) < 1e-3f);
        const glm::vec3 middle = 0.5f * (world.pose(halves[0]).position + world.pose(halves[1]).position);
        REQUIRE(glm::length(middle - as_one.pose(one).position) < 1e-3f);
        const glm::quat apart = glm::conjugate(as_one.pose(one).orientation) * world.pose(halves[0]).orientation;
        REQUIRE(2.0f * glm::length(glm::vec3(apart.x, apart.y, apart.z)) < 0.05f);
    }
    const Mechanics end = world.mechanics();
    CHECK(glm::length(end.momentum - start.momentum) < 1e-4 * glm::length(start.momentum));
    CHECK(glm::length(end.angular_momentum - start.angular_momentum) < 0.01 * glm::length(start.angular_momentum));
    CHECK(end.kinetic == doctest::Approx(start.kinetic).epsilon(0.01));
}

TEST_CASE("fixed joints: a beam of ten boxes sticks out of a wall, and bears a box of as much weight at its end") {
    World world(in_vacuum);
    std::vector<JointId> joints;
    BodyId before;
    for (int i = 0; i < 11; ++i) {
        const glm::vec3 from(0.2f * static_cast<float>(i), 0, 0);
        const BodyId next = must_add(world, box(glm::vec3(0.1f), i == 10 ? 10.0f : 1.0f, from + glm::vec3(0.1f, 0, 0)));
        joints.push_back(must_join(world, {.kind = JointKind::fixed, .a = next, .b = before, .anchor_a = from}));
        before = next;
    }
    const float height = world.pose(before).position.y;
    run(world, 5.0f);
    CHECK(std::abs(world.pose(before).position.y - height) < 1e-3f);
    for (size_t i = 0; i < joints.size(); ++i)
        CHECK(world.joint_force(joints[i]) == doctest::Approx(g * (20.0f - static_cast<float>(i))).epsilon(0.01));
}

TEST_CASE("fixed joints: force and torque break a joint by the sum of their shares") {
    struct Case {
        float force_share, torque_share; // of what the joint bears
        bool holds;
    };
    for (const Case& one : {Case{0.99f, 0.0f, true}, Case{1.01f, 0.0f, false}, Case{0.0f, 0.99f, true},
                            Case{0.0f, 1.01f, false}, Case{0.5f, 0.49f, true}, Case{0.5f, 0.51f, false}}) {
        CAPTURE(one.force_share);
        CAPTURE(one.torque_share);
        Bracket bracket;
        bracket.weld({0, 0, 0}, one.force_share > 0.0f ? Bracket::weight / one.force_share : infinity,
                     one.torque_share > 0.0f ? Bracket::weight * Bracket::arm / one.torque_share : infinity);
        CHECK(bracket.holds() == one.holds);
    }
    // About an anchor below the middle the weight has no torque.
    Bracket bracket;
    bracket.weld({Bracket::arm, -0.1f, 0}, infinity, 0.01f * Bracket::weight);
    CHECK(bracket.holds());
}

TEST_CASE("fixed joints: the step in which a joint breaks gives what the joint bears") {
    Bracket bracket;
    bracket.weld({Bracket::arm, 0, 0}, 0.75f * Bracket::weight);
    bracket.world.step();
    CHECK(bracket.world.joints().empty());
    CHECK(bracket.world.linear_velocity(bracket.box).y == doctest::Approx(-0.25f * g / 120.0f).epsilon(0.01));
}

TEST_CASE("fixed joints: several hold a load together, each by its strength") {
    const glm::vec3 below(Bracket::arm, -0.05f, 0), above(Bracket::arm, 0.05f, 0); // on one vertical
    for (const float strength : {1.0f, 3.0f}) { // of the second, as a multiple of the first
        CAPTURE(strength);
        const float least = Bracket::weight / (1.0f + strength);
        for (const bool holds : {true, false}) {
            Bracket bracket;
            const float share = holds ? 1.2f : 0.8f;
            const JointId first = bracket.weld(below, share * least);
            const JointId second = bracket.weld(above, share * strength * least);
            CHECK(bracket.holds() == holds);
            if (!holds) {
                CHECK(bracket.world.joints().empty()); // one cannot bear what both could not
                continue;
            }
            CHECK(bracket.world.joint_force(first) == doctest::Approx(least).epsilon(0.15));
            CHECK(bracket.world.joint_force(second) == doctest::Approx(strength * least).epsilon(0.15));
        }
    }
}

TEST_CASE("fixed joints: what presses two faces together does not break glue between them") {
    const auto holds = [](float height, bool bears_pressure) { // of the box over the world's point
        World world(in_vacuum);
        const BodyId body = must_add(world, box(glm::vec3(0.1f), 10.0f, {0, height, 0}));
        must_join(world, {.kind = JointKind::fixed,
                          .a = body,
                          .anchor_a = {0, 0, 0},
                          .axis = {0, -height, 0},
                          .max_force = 0.5f * Bracket::weight,
                          .bears_pressure = bears_pressure});
        run(world, 0.5f);
        return !world.joints().empty();
    };
    CHECK(holds(0.1f, true));        // stands
    CHECK_FALSE(holds(-0.1f, true)); // hangs
    CHECK_FALSE(holds(0.1f, false));
    CHECK_FALSE(holds(-0.1f, false));
}

TEST_CASE("fixed joints: taken from a body, a joint holds the body that replaces it as it stands") {
    World world(in_vacuum);
    const BodyId post = must_add(world, box(glm::vec3(0.1f), 1.0f, {0, 0, 0}));
    must_join(world, {.kind = JointKind::fixed, .a = post, .anchor_a = {0, -0.1f, 0}});
    const BodyId arm = must_add(world, box({0.3f, 0.05f, 0.05f}, 1.0f, {0.4f, 0, 0}));
    must_join(world, {.kind = JointKind::fixed, .a = arm, .b = post, .anchor_a = {0.1f, 0, 0}, .axis = {-1, 0, 0}});
    run(world, 0.1f);
    const std::vector<LooseJoint> taken = world.take_joints(arm);
    REQUIRE(taken.size() == 1);
    world.remove_body(arm);
    BodyDesc rest = box({0.05f, 0.15f, 0.05f}, 0.5f, {0.25f, 0, 0}); // other principal axes, and turned
    rest.pose.orientation = glm::angleAxis(1.5707963f, glm::vec3(0, 0, 1));
    const BodyId piece = must_add(world, rest);
    const Shape shape(world, post, piece);
    REQUIRE(world.put_joint(taken[0], piece));
    run(world, 2.0f);
    CHECK(shape.moved(world) < 1e-4f);
    CHECK(shape.turned(world) < 1e-3f);
    CHECK(std::abs(world.pose(piece).position.y) < 1e-3f);
}

TEST_CASE("fixed joints: stock Bullet holds and breaks them by the same rule") {
    WorldSettings settings = in_vacuum;
    settings.engine = EngineKind::bullet;
    for (const bool holds : {true, false}) {
        CAPTURE(holds);
        World by_force(settings), by_torque(settings), pressed(settings);
        const float share = holds ? 1.1f : 0.9f;
        const auto bracket = [](World& world) { return must_add(world, box({0.2f, 0.1f, 0.1f}, 10.0f, {0.5f, 0, 0})); };
        must_join(by_force, {.kind = JointKind::fixed, .a = bracket(by_force), .max_force = share * Bracket::weight});
        const BodyId arm = bracket(by_torque);
        must_join(by_torque,
                  {.kind = JointKind::fixed, .a = arm, .max_torque = share * Bracket::weight * Bracket::arm});
        must_join(pressed, {.kind = JointKind::fixed,
                            .a = bracket(pressed),
                            .axis = {0, holds ? -1.0f : 1.0f, 0},
                            .max_force = 0.5f * Bracket::weight,
                            .bears_pressure = true});
        for (World* world : {&by_force, &by_torque, &pressed}) {
            run(*world, 1.0f);
            CHECK(world->joints().size() == (holds ? 1u : 0u));
        }
        if (holds) {
            CHECK(std::abs(by_torque.pose(arm).position.y) < 0.01f);
        }
    }
}
