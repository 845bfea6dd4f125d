// Resting bodies in an island that is awake: they do not creep, they move when pushed, and they fall when their support
// is gone.
#include <cmath>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "physics/world/world.h"
#include "tests/physics/bodies.h"
#include "tests/physics/joints.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

// Two stacked boxes beside a third one, which is disturbed in each step: none of the three falls asleep.
struct Neighbours {
    World world;
    BodyId lower, upper, restless;

    Neighbours() {
        lower = must_add(world, box(glm::vec3(0.1f), 8.0f, {0.0f, 0.1f, 0.0f}));
        upper = must_add(world, box(glm::vec3(0.1f), 8.0f, {0.0f, 0.3f, 0.0f}));
        restless = must_add(world, box(glm::vec3(0.1f), 8.0f, {0.2005f, 0.1f, 0.0f}));
    }
    void step() {
        world.set_velocity(restless, {}, {});
        world.step();
    }
    void settle() {
        for (int i = 0; i < 240; ++i) step();
        REQUIRE(world.awake(upper));
    }
};

} // namespace

TEST_CASE("resting: bodies beside a restless one keep their place to the bit, and press by their weight") {
    Neighbours three;
    three.settle();
    const glm::vec3 lower = three.world.pose(three.lower).position, upper = three.world.pose(three.upper).position;
    const double weight = 8.0 * 9.81 / 120.0;
    for (int i = 0; i < 240; ++i) {
        three.step();
        CHECK(three.world.pose(three.lower).position == lower);
        CHECK(three.world.pose(three.upper).position == upper);
        double on_ground = 0.0, between = 0.0;
        for (const Contact& contact : three.world.contacts()) {
            if (contact.a == three.lower && contact.b == BodyId{}) on_ground += static_cast<double>(contact.impulse);
            if ((contact.a == three.lower && contact.b == three.upper)
                || (contact.a == three.upper && contact.b == three.lower))
                between += static_cast<double>(contact.impulse);
        }
        CHECK(on_ground == doctest::Approx(2.0 * weight).epsilon(0.05));
        CHECK(between == doctest::Approx(weight).epsilon(0.05));
    }
    CHECK(three.world.awake(three.lower));
    CHECK(three.world.awake(three.upper));
}

TEST_CASE("resting: a body alone near a restless one keeps its place to the bit, and presses by its weight") {
    World world;
    const BodyId rests = must_add(world, box(glm::vec3(0.1f), 8.0f, {0.0f, 0.1f, 0.0f}));
    const BodyId restless =
        must_add(world, box(glm::vec3(0.1f), 8.0f, {0.2035f, 0.1f, 0.0f})); // boxes overlap, bodies do not touch
    const auto step = [&] {
        world.set_velocity(restless, {}, {});
        world.step();
    };
    for (int i = 0; i < 240; ++i) step();
    const glm::vec3 before = world.pose(rests).position;
    for (int i = 0; i < 120; ++i) {
        step();
        REQUIRE(world.awake(rests));
        CHECK(world.pose(rests).position == before);
        double on_ground = 0.0;
        for (const Contact& contact : world.contacts()) {
            REQUIRE((contact.a == BodyId{} || contact.b == BodyId{}));
            if (contact.a == rests) on_ground += static_cast<double>(contact.impulse);
        }
        CHECK(on_ground == doctest::Approx(8.0 * 9.81 / 120.0).epsilon(0.05));
    }
}

TEST_CASE("resting: a body falls when its support moves away, fast or slowly") {
    for (const float speed : {5.0f, 0.15f}) {
        CAPTURE(speed);
        Neighbours three;
        three.settle();
        REQUIRE(three.world.pose(three.upper).position.y > 0.29f);
        const int steps = static_cast<int>(0.5f / speed * 120.0f) + 60;
        for (int i = 0; i < steps; ++i) {
            // Away from both others.
            if (three.world.pose(three.lower).position.z < 0.4f)
                three.world.set_velocity(three.lower, {0.0f, 0.0f, speed}, {});
            three.step();
        }
        for (int i = 0; i < 120; ++i) three.step();
        const glm::vec3 up = three.world.pose(three.upper).position, low = three.world.pose(three.lower).position;
        // On the ground, or still on the lower box.
        CAPTURE(up.y);
        CHECK((std::abs(up.y - 0.1f) < 0.01f || (std::abs(up.y - 0.3f) < 0.01f && std::abs(up.z - low.z) < 0.1f)));
    }
}

TEST_CASE("resting: a body moves when it is pushed") {
    Neighbours three;
    three.settle();
    const float before = three.world.pose(three.lower).position.x;
    for (int i = 0; i < 120; ++i) {
        three.world.set_velocity(three.restless, {-0.2f, 0.0f, 0.0f}, {});
        three.world.step();
    }
    CHECK(three.world.pose(three.lower).position.x < before - 0.05f);
    CHECK(three.world.pose(three.restless).position.x - three.world.pose(three.lower).position.x > 0.19f);
}

TEST_CASE("resting: a body follows what a joint ties it to, however long both lay still") {
    Neighbours three;
    const BodyId tractor = must_add(three.world, box(glm::vec3(0.1f), 1000.0f, {-1.0f, 0.1f, 0.0f}));
    must_join(three.world, {.kind = JointKind::distance,
                            .a = three.lower,
                            .b = tractor,
                            .anchor_a = {0.0f, 0.1f, 0.0f},
                            .anchor_b = {-1.0f, 0.1f, 0.0f},
                            .min_length = 1.0f,
                            .max_length = 1.0f});
    three.settle();
    const float before = three.world.pose(three.lower).position.x;
    for (int i = 0; i < 120; ++i) {
        three.world.set_velocity(tractor, {-0.05f, 0.0f, 0.0f}, {});
        three.step();
    }
    CHECK(three.world.pose(three.lower).position.x == doctest::Approx(before - 0.05f).epsilon(0.1));
    CHECK(three.world.pose(three.upper).position.x == doctest::Approx(before - 0.05f).epsilon(0.1));
}

TEST_CASE("resting: a blow moves a resting body as it moves one that does not rest") {
    const auto hit = [](bool rested) {
        Neighbours three;
        if (rested) three.settle();
        BodyDesc ball = box(glm::vec3(0.1f), 30.0f, {-1.0f, 0.3f, 0.0f});
        ball.linear_velocity = {4.0f, 0.0f, 0.0f};
        must_add(three.world, ball);
        for (int i = 0; i < 60; ++i) three.step();
        return three.world.pose(three.upper).position.x;
    };
    const float moved = hit(false);
    CHECK(moved > 0.02f);
    CHECK(hit(true) == doctest::Approx(moved).epsilon(0.1));
}
