#include "physics/cutting/contact_blows.h"

#include <cmath>
#include <optional>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "tests/physics/bodies.h"
#include "tests/physics/destruction_fixture.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;
using test_destruction::shoot;

namespace {

constexpr float min_speed = 0.5f;

// A fixed block whose front lies at z = 0, and the blows to it.
struct Hit {
    World world;
    BlowTracker tracker;
    BodyId block;
    std::vector<BodyBlow> blows;

    explicit Hit(const WorldSettings& settings = empty_space) : world(settings) {
        BodyDesc desc = box(glm::vec3(0.5f), 2400.0f, {0.0f, 0.0f, -0.5f});
        desc.fixed = true;
        block = test_bodies::must_add(world, desc);
    }
    void update() {
        for (const BodyBlow& blow : tracker.update(world, min_speed, [&](BodyId body) { return body == block; }))
            blows.push_back(blow);
    }
    void run(int steps) {
        for (int i = 0; i < steps; ++i) world.step(), update();
    }
};

} // namespace

TEST_CASE("contact blows: an empty world, distant bodies and slow contacts give none") {
    World empty;
    BlowTracker tracker;
    empty.step();
    CHECK(tracker.update(empty, min_speed, [](BodyId) { return true; }).empty());
    for (const float speed : {0.0f, 0.4f}) {
        Hit slow;
        shoot(slow.world, 0.1f, 20.0f, {0.0f, 0.0f, 0.105f}, {0.0f, 0.0f, -speed});
        slow.run(30);
        CHECK(slow.blows.empty());
    }
}

TEST_CASE("contact blows: a body that is removed during a blow reports none") {
    for (const bool removed : {false, true}) {
        Hit hit;
        const BodyId ram = test_bodies::must_add(hit.world, box(glm::vec3(0.5f), 400.0f, {0.0f, 0.0f, 0.502f}));
        hit.world.set_velocity(ram, {0.0f, 0.0f, -2.0f}, glm::vec3(0.0f));
        hit.world.step();
        REQUIRE_FALSE(hit.world.contacts().empty());
        hit.world.set_velocity(ram, {0.0f, 0.0f, -2.0f}, glm::vec3(0.0f)); // it pushes on
        hit.update();
        REQUIRE(hit.blows.empty());
        if (removed) hit.world.remove_body(hit.block);
        hit.run(5);
        CHECK(hit.blows.empty() == removed);
    }
}

TEST_CASE("contact blows: a collision is one blow with its whole impulse, at any time within a step") {
    for (const bool block : {false, true})
        for (const float speed : {0.7f, 1.2f, 2.0f, 3.0f, 6.0f, 25.0f})
            for (int millimetres = 0; millimetres < 25; ++millimetres) {
                CAPTURE(block);
                CAPTURE(speed);
                CAPTURE(millimetres);
                Hit hit;
                const float mass = 20.0f, half = block ? 0.4f : 0.1f;
                const glm::vec3 from(0.05f, 0.0f, half + 0.2f + 1e-3f * static_cast<float>(millimetres));
                const glm::vec3 velocity(0.0f, 0.0f, -speed);
                BodyId striker;
                if (block) {
                    striker = test_bodies::must_add(hit.world, box(glm::vec3(half), mass, from));
                    hit.world.set_velocity(striker, velocity, glm::vec3(0.0f));
                } else {
                    striker = shoot(hit.world, half, mass, from, velocity);
                }
                int pressing = 0;
                for (int step = 0; hit.blows.empty(); ++step) {
                    REQUIRE(step < 100);
                    hit.run(1);
                    if (!hit.world.contacts().empty()) ++pressing;
                }
                const float gained = mass * (hit.world.linear_velocity(striker).z + speed);
                REQUIRE(hit.blows.size() == 1);
                const BodyBlow& blow = hit.blows[0];
                CHECK(pressing == 1); // a step stops the body whole
                CHECK(blow.other == striker);
                // The whole impulse that stopped the body, less contacts below the speed of a blow.
                CHECK(blow.impulse == doctest::Approx(gained).epsilon(1e-3));
                CHECK(blow.energy == doctest::Approx(0.5f * blow.impulse * speed).epsilon(1e-3));
                CHECK(glm::distance(blow.normal, velocity / speed) < 1e-3f);
                CHECK(glm::distance(glm::vec2(blow.point), glm::vec2(0.05f, 0.0f))
                      < (block ? 0.5f : 0.03f)); // the ball has facets
                CHECK(std::abs(blow.point.z - 0.5f) < speed / 120.0f + 0.01f);
                CHECK(glm::length(blow.arm) < 2.0f * half);
                if (block) continue; // a block may turn and hit again
                CHECK(gained >= mass * (speed - min_speed));
                hit.run(20);
                CHECK(hit.blows.size() == 1);
            }
}

TEST_CASE("contact blows: a slab that lands flat is one blow with all of its energy") {
    for (const float height : {0.03f, 0.05f, 0.1f, 0.2f, 0.4f}) {
        CAPTURE(height);
        Hit hit(WorldSettings{});
        BodyDesc slab = box({0.45f, 0.1f, 0.45f}, 400.0f, {0.0f, 0.6f + height, -0.5f});
        slab.restitution = 0.0f;
        test_bodies::must_add(hit.world, slab);
        hit.run(60);
        REQUIRE(hit.blows.size() == 1);
        // The slab's weight adds to the impulse while it stops; contacts below 0.5 m/s do not count.
        const float energy = 400.0f * 9.81f * height, steps = 3.0f * 400.0f * 9.81f / 120.0f;
        CHECK(hit.blows[0].impulse >= std::sqrt(2.0f * 400.0f * energy) - 400.0f * min_speed);
        CHECK(hit.blows[0].impulse <= std::sqrt(2.0f * 400.0f * energy) + steps);
        CHECK(hit.blows[0].energy > 0.75f * energy);
    }
}

TEST_CASE("contact blows: a resting body of any mass never adds up to a blow") {
    for (const float mass : {1.0f, 1e3f, 1e6f}) {
        Hit hit(WorldSettings{.sleeping = false});
        test_bodies::must_add(hit.world, box({0.3f, 0.3f, 0.3f}, mass, {0.1f, 0.801f, -0.5f}));
        hit.run(480);
        CHECK(hit.blows.empty());
        CHECK_FALSE(hit.world.contacts().empty());
    }
}

TEST_CASE("contact blows: a longer push is one blow every four steps") {
    Hit hit;
    const BodyId ram = shoot(hit.world, 0.1f, 20.0f, {0.0f, 0.0f, 0.2f}, {0.0f, 0.0f, -2.0f});
    float total_impulse = 0.0f;
    for (int step = 0; step < 41; ++step) {
        hit.world.step();
        for (const Contact& contact : hit.world.contacts()) total_impulse += contact.impulse;
        hit.world.set_velocity(ram, {0.0f, 0.0f, -2.0f}, glm::vec3(0.0f));
        hit.update();
    }
    REQUIRE(hit.blows.size() >= 7);
    float sum = 0.0f;
    for (const BodyBlow& blow : hit.blows) {
        CHECK(blow.impulse
              == doctest::Approx(160.0f).epsilon(0.35)); // four times 20 kg at 2 m/s, less before a gap had closed
        sum += blow.impulse;
    }
    CHECK(sum <= total_impulse * 1.0001f);
    CHECK(sum >= total_impulse - 160.0f * 1.35f); // without blows that still last
}
