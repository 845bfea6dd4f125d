// Compounds, fixed bodies, and reported contacts. Compounds on compounds: test_compound_contact.cpp.
#include "physics/world/world.h"

#include <array>
#include <cmath>
#include <memory>
#include <string>

#include <doctest/doctest.h>

#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

BodyDesc slabs(const glm::vec3& half, int count, float mass, const glm::vec3& position) {
    return in_slabs(box(half, mass, position), half, count);
}

} // namespace

TEST_CASE("compound: a body of one part equals the body of that hull, bit for bit") {
    World plain, parts;
    BodyDesc desc = box({0.2f, 0.1f, 0.15f}, 3.0f, {0.0f, 1.0f, 0.0f});
    desc.angular_velocity = {1.0f, 2.0f, 3.0f};
    must_add(plain, desc);
    desc.parts.push_back({std::make_shared<const CollisionHull>(desc.hull), glm::vec3(0.0f)});
    desc.hull = {};
    must_add(parts, desc);
    run(plain, 2.0f);
    run(parts, 2.0f);
    CHECK(plain.state_hash() == parts.state_hash());
}

TEST_CASE("compound: an invalid part is refused with its number") {
    World world;
    const BodyDesc good = slabs({0.2f, 0.1f, 0.1f}, 3, 1.0f, {});
    std::array<BodyDesc, 3> bad{good, good, good};
    bad[0].parts[1].hull = nullptr;
    bad[1].parts[2].offset.y = NAN;
    bad[2].parts[0].hull = std::make_shared<const CollisionHull>();
    for (size_t i = 0; i < bad.size(); ++i) {
        const Result<BodyId> id = world.add_body(bad[i]);
        REQUIRE_FALSE(id.has_value());
        CHECK(id.error().message.find("part " + std::to_string((i + 1) % 3)) != std::string::npos);
    }
    CHECK(world.body_count() == 0);
    CHECK(world.add_body(good).has_value());
}

TEST_CASE("compound: it stands on the ground without a gap, and each hull reports its contacts") {
    World world({.sleeping = false});
    const BodyId id = must_add(world, slabs({0.3f, 0.1f, 0.1f}, 3, 9.0f, {0.0f, 0.1f, 0.0f}));
    run(world, 2.0f);
    CHECK(std::abs(world.pose(id).position.y - 0.1f) < 1e-3f);
    CHECK(std::abs(world.pose(id).position.x) < 1e-3f);
    std::array<float, 3> carried{};
    for (const Contact& contact : world.contacts()) {
        CHECK(contact.a == id);
        CHECK(contact.b == BodyId{});
        REQUIRE(contact.part_a < 3);
        carried[contact.part_a] += contact.impulse;
        CHECK(contact.normal.y == 1.0f);
        CHECK(std::abs(contact.point.y) < 1e-3f);
        CHECK(std::abs(contact.speed) < 0.01f);
        // Below the named slab.
        CHECK(std::abs(contact.point.x - (-0.2f + 0.2f * static_cast<float>(contact.part_a))) < 0.11f);
    }
    // In each step the ground's impulse cancels gravity's.
    CHECK(carried[0] + carried[1] + carried[2] == doctest::Approx(9.0 * 9.81 / 120.0).epsilon(0.02));
    std::vector<DebugLine> lines;
    world.debug_lines(lines);
    CHECK(lines.size() == 36);
    for (const DebugLine& line : lines) {
        CHECK(std::abs(line.from.x) < 0.301f);
        CHECK(std::abs(line.from.y - 0.1f) < 0.101f);
    }
}

TEST_CASE("compound: an L of two boxes falls over if its centre of mass overhangs, and stands if not") {
    for (const bool overhangs : {false, true}) {
        World world;
        // A leg, a cube of 0.2 m, and an arm on top of it.
        const float arm = overhangs ? 0.8f : 0.3f, density = 1000.0f;
        const float leg_mass = 0.008f * density, arm_mass = arm * 0.04f * density, mass = leg_mass + arm_mass;
        const glm::vec3 leg(0.0f, 0.1f, 0.0f), top(arm * 0.5f - 0.1f, 0.3f, 0.0f);
        const glm::vec3 centre = (leg * leg_mass + top * arm_mass) / mass;
        BodyDesc desc;
        desc.mass = mass;
        desc.pose.position = centre;
        desc.inertia = glm::mat3(0.0f);
        for (const auto& [place, half, part] : {std::tuple(leg, glm::vec3(0.1f), leg_mass),
                                                std::tuple(top, glm::vec3(arm * 0.5f, 0.1f, 0.1f), arm_mass)}) {
            const glm::vec3 r = place - centre;
            desc.inertia += box_inertia(half, part) + part * (glm::mat3(glm::dot(r, r)) - glm::outerProduct(r, r));
            desc.parts.push_back({std::make_shared<const CollisionHull>(box_hull(half)), r});
        }
        const BodyId id = must_add(world, desc);
        run(world, 3.0f);
        const glm::vec3 up = world.pose(id).orientation * glm::vec3(0.0f, 1.0f, 0.0f);
        CAPTURE(overhangs);
        CHECK((up.y > 0.999f) == !overhangs);
        CHECK(world.pose(id).position.y > 0.05f);
    }
}

TEST_CASE("compound: it collides with its hulls, not with the box around them, and momentum survives") {
    World world(empty_space);
    // A U: a box flies between its arms and hits the bottom.
    BodyDesc desc;
    desc.mass = 10.0f;
    desc.inertia = box_inertia({0.5f, 0.5f, 0.1f}, 10.0f);
    const auto arm = std::make_shared<const CollisionHull>(box_hull({0.1f, 0.5f, 0.1f}));
    const auto bottom = std::make_shared<const CollisionHull>(box_hull({0.3f, 0.1f, 0.1f}));
    desc.parts = {{arm, {-0.4f, 0.0f, 0.0f}}, {bottom, {0.0f, -0.4f, 0.0f}}, {arm, {0.4f, 0.0f, 0.0f}}};
    const BodyId cup = must_add(world, desc);
    BodyDesc ball = box({0.1f, 0.1f, 0.1f}, 1.0f, {0.05f, 1.0f, 0.0f});
    ball.linear_velocity = {0.0f, -4.0f, 0.0f};
    ball.restitution = 0.0f;
    const BodyId flying = must_add(world, ball);
    const Mechanics before = world.mechanics();
    float lowest = 1.0f;
    double impulse = 0.0;
    for (int step = 0; step < 60; ++step) {
        world.step();
        lowest = std::min(lowest, world.pose(flying).position.y);
        for (const Contact& contact : world.contacts()) {
            const bool cup_first = contact.a == cup;
            CHECK((cup_first ? contact.part_a : contact.part_b) == 1);
            CHECK((cup_first ? -contact.normal.y : contact.normal.y) > 0.99f);
            if (impulse == 0.0) CHECK(contact.speed == doctest::Approx(4.0).epsilon(1e-3));
        }
        for (const Contact& contact : world.contacts()) impulse += contact.impulse;
    }
    const Mechanics after = world.mechanics();
    CHECK(lowest < -0.1f);
    CHECK(world.pose(flying).position.y - world.pose(cup).position.y > -0.21f);
    CHECK(world.linear_velocity(cup).y < -0.1f);
    CHECK(impulse == doctest::Approx(-world.mechanics(cup).momentum.y).epsilon(1e-3));
    CHECK(glm::length(after.momentum - before.momentum) < 1e-4 * glm::length(before.momentum));
}

TEST_CASE("fixed bodies: one carries the body on it, cannot be moved, and after its removal the body falls") {
    World world;
    BodyDesc shelf = slabs({0.5f, 0.05f, 0.5f}, 4, 1.0f, {0.0f, 1.0f, 0.0f});
    shelf.fixed = true;
    shelf.linear_velocity = {1.0f, 0.0f, 0.0f};
    const BodyId held = must_add(world, shelf);
    const BodyId on_top = must_add(world, box({0.1f, 0.1f, 0.1f}, 5.0f, {0.0f, 1.2f, 0.0f}));
    run(world, 2.0f);
    world.apply_impulse(held, {100.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f});
    world.set_velocity(held, {1.0f, 0.0f, 0.0f}, {});
    CHECK(world.response(held, {}, {0.0f, 1.0f, 0.0f}) == 0.0f);
    run(world, 1.0f);
    CHECK(world.fixed(held));
    CHECK_FALSE(world.awake(held));
    CHECK(world.awake_count() == 0);
    CHECK(world.pose(held).position == glm::vec3(0.0f, 1.0f, 0.0f));
    CHECK(world.linear_velocity(held) == glm::vec3(0.0f));
    CHECK(world.mechanics(held).kinetic == 0.0);
    CHECK(world.mechanics(held).potential == 0.0);
    CHECK(std::abs(world.pose(on_top).position.y - 1.15f) < 2e-3f);
    float carried = 0.0f; // the sleeping body still presses
    for (const Contact& contact : world.contacts()) carried += contact.impulse;
    CHECK(carried == doctest::Approx(5.0 * 9.81 / 120.0).epsilon(0.05));
    CHECK(world.remove_body(held));
    run(world, 2.0f);
    CHECK(world.pose(on_top).position.y == doctest::Approx(0.1).epsilon(0.02).scale(0.0));
}

TEST_CASE("contacts: normal and friction impulses equal the change of momentum") {
    World world(empty_space);
    const BodyId left = must_add(world, box({0.1f, 0.1f, 0.1f}, 1.0f, {-0.3f, 0.0f, 0.0f}));
    BodyDesc desc = box({0.1f, 0.1f, 0.1f}, 2.0f, {0.3f, 0.02f, 0.01f});
    desc.linear_velocity = {-3.0f, 1.0f, 0.5f};
    const BodyId right = must_add(world, desc);
    size_t seen = 0;
    for (int step = 0; step < 30; ++step) {
        const glm::dvec3 before = world.mechanics(left).momentum;
        world.step();
        glm::dvec3 given(0.0);
        for (const Contact& contact : world.contacts()) {
            CHECK((contact.a == left || contact.b == left));
            CHECK((contact.a == right || contact.b == right));
            CHECK(std::abs(glm::dot(contact.friction, contact.normal)) < 1e-4f);
            const glm::dvec3 impulse(contact.impulse * contact.normal + contact.friction);
            given += contact.a == left ? impulse : -impulse;
            seen += glm::length(contact.friction) > 0.1f ? 1u : 0u;
        }
        CHECK(glm::length(world.mechanics(left).momentum - before - given) < 1e-4);
    }
    CHECK(seen > 0);
}

TEST_CASE("world: velocities can be replaced, and a response is the inverse effective mass") {
    World world(empty_space);
    const BodyId id = must_add(world, box({0.1f, 0.2f, 0.3f}, 2.0f, {1.0f, 2.0f, 3.0f}));
    world.set_velocity(id, {1.0f, 2.0f, 3.0f}, {4.0f, 5.0f, 6.0f});
    CHECK(glm::length(world.linear_velocity(id) - glm::vec3(1.0f, 2.0f, 3.0f)) < 1e-6f);
    CHECK(world.angular_velocity(id) == glm::vec3(4.0f, 5.0f, 6.0f));
    world.set_velocity(id, {}, {});
    CHECK(world.response(id, {1.0f, 2.0f, 3.0f}, {0.0f, 1.0f, 0.0f}) == doctest::Approx(0.5));
    const glm::vec3 point(1.1f, 2.2f, 3.3f);
    world.apply_impulse(id, {0.0f, 1.0f, 0.0f}, point);
    const glm::vec3 arm = point - glm::vec3(1.0f, 2.0f, 3.0f);
    const float speed = (world.linear_velocity(id) + glm::cross(world.angular_velocity(id), arm)).y;
    CHECK(world.response(id, point, {0.0f, 1.0f, 0.0f}) == doctest::Approx(speed).epsilon(1e-4));
}

TEST_CASE("world: advance calls back after each of its steps") {
    World world;
    int calls = 0;
    world.advance(2.5 / 120.0, [&] { ++calls; });
    CHECK(calls == 2);
}

TEST_CASE("compound: the same calls give the same state, in a new world and in a cleared one") {
    const auto play = [](World& world) {
        test::Random random(11);
        for (int i = 0; i < 12; ++i) {
            BodyDesc desc =
                slabs({0.2f, 0.1f, 0.05f}, 1 + i % 4, 2.0f, glm::vec3(random.point({-1, 1, -1}, {1, 3, 1})));
            desc.angular_velocity = glm::vec3(random.point(glm::dvec3(-3.0), glm::dvec3(3.0)));
            must_add(world, desc);
        }
        run(world, 2.0f);
        return world.state_hash();
    };
    check_repeats(play);
}
