// Compounds on compounds: they rest on each other, keep momentum, and collide with their hulls.
#include "physics/solver/compound_contact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "physics/solver/manifold.h"
#include "physics/world/world.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

// A beam of slabs.
BodyDesc beam(const glm::vec3& half, int count, float mass, const glm::vec3& position) {
    return in_slabs(box(half, mass, position), half, count);
}

// Three bars that span the coordinate axes: every pair of these bodies may interlock.
BodyDesc cross_of_bars(float mass, const glm::vec3& position) {
    BodyDesc desc;
    desc.mass = mass;
    desc.pose.position = position;
    desc.inertia = glm::mat3(0.0f);
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec3 half(0.03f);
        half[axis] = 0.2f;
        desc.inertia += box_inertia(half, mass / 3.0f);
        desc.parts.push_back({std::make_shared<const CollisionHull>(box_hull(half)), glm::vec3(0.0f)});
    }
    return desc;
}

double relative(const glm::dvec3& after, const glm::dvec3& before) {
    return glm::length(after - before) / glm::length(before);
}

} // namespace

TEST_CASE("compound on compound: beams that lie on each other in turns rest without sinking") {
    World world;
    const glm::vec3 half(0.3f, 0.05f, 0.1f);
    std::vector<BodyId> beams;
    for (int i = 0; i < 5; ++i) {
        BodyDesc one = beam(half, 6, 10.0f, {0.0f, 0.05f + 0.1f * static_cast<float>(i), 0.0f});
        one.pose.orientation = glm::angleAxis(i % 2 == 0 ? 0.0f : 1.5707964f, glm::vec3(0.0f, 1.0f, 0.0f));
        beams.push_back(must_add(world, one));
    }
    for (int step = 0; step < 600; ++step) {
        world.step();
        for (size_t i = 0; i < beams.size(); ++i) {
            const float height = 0.05f + 0.1f * static_cast<float>(i);
            CHECK(std::abs(world.pose(beams[i]).position.y - height) < 3e-3f); // until overlap is corrected
        }
    }
    CHECK(world.awake_count() == 0);
    // Each contact keeps an overlap of at most the slop; those below a beam add up.
    const float slop = slop_part * glm::length(half), rounding = 2e-5f;
    for (size_t i = 0; i < beams.size(); ++i) {
        const float sunk = 0.05f + 0.1f * static_cast<float>(i) - world.pose(beams[i]).position.y;
        CHECK(sunk < static_cast<float>(i + 1) * slop + rounding);
        CHECK(sunk > -rounding);
    }
    // Each carries those above it.
    for (size_t i = 1; i < beams.size(); ++i) {
        float carried = 0.0f;
        for (const Contact& contact : world.contacts())
            if (contact.a == beams[i] && contact.b == beams[i - 1])
                carried += contact.impulse * contact.normal.y;
            else if (contact.a == beams[i - 1] && contact.b == beams[i])
                carried -= contact.impulse * contact.normal.y;
        CHECK(carried == doctest::Approx(static_cast<double>(beams.size() - i) * 10.0 * 9.81 / 120.0).epsilon(0.05));
    }
}

TEST_CASE("compound on compound: a dropped pile of crosses comes to rest, no bar deep in another or in the ground") {
    World world;
    test::Random random(3);
    std::vector<BodyId> crosses;
    for (int i = 0; i < 40; ++i) {
        BodyDesc one = cross_of_bars(3.0f, glm::vec3(random.point({-0.1, 0.4, -0.1}, {0.1, 0.6, 0.1})));
        one.pose.position.y += 0.35f * static_cast<float>(i);
        one.pose.orientation =
            glm::angleAxis(static_cast<float>(random.uniform(0.0, 3.0)), glm::vec3(random.direction()));
        crosses.push_back(must_add(world, one));
    }
    EnergyBooks energy(world);
    for (int step = 0; step < 1200; ++step) {
        world.step();
        energy.look(world);
    }
    float deepest = 0.0f;
    size_t between = 0;
    for (const Contact& contact : world.contacts()) {
        deepest = std::min(deepest, contact.gap);
        between += contact.b != BodyId{};
    }
    MESSAGE("deepest ", deepest, " m, ", between, " contacts between crosses, energy rose by ",
            energy.risen / energy.start, " of the start");
    CHECK(between > 10);
    CHECK(deepest > -2e-3f);
    CHECK(energy.risen < 5e-4 * energy.start);
    CHECK(greatest_speed(world) < 0.05f);
    for (const BodyId id : crosses) CHECK(world.pose(id).position.y > 0.03f);
}

TEST_CASE("compound on compound: momentum and angular momentum survive collisions, and energy does not rise") {
    test::Random random(5);
    int collided = 0;
    for (int place = 0; place < 20; ++place) {
        CAPTURE(place);
        World world(empty_space);
        BodyDesc first = cross_of_bars(2.0f, {-0.35f, 0.0f, 0.0f}), second = cross_of_bars(3.0f, {0.35f, 0.0f, 0.0f});
        for (BodyDesc* one : {&first, &second}) {
            one->pose.position += glm::vec3(random.point(glm::dvec3(-0.05), glm::dvec3(0.05)));
            one->pose.orientation =
                glm::angleAxis(static_cast<float>(random.uniform(0.0, 3.0)), glm::vec3(random.direction()));
            one->angular_velocity = glm::vec3(random.point(glm::dvec3(-4.0), glm::dvec3(4.0)));
            one->linear_velocity.x = -3.0f * one->pose.position.x;
        }
        first.linear_velocity.y = 0.5f;
        must_add(world, first);
        must_add(world, second);
        const Mechanics before = world.mechanics();
        double least = before.kinetic;
        bool touched = false;
        for (int step = 0; step < 120; ++step) {
            world.step();
            const Mechanics now = world.mechanics();
            touched = touched || !world.contacts().empty();
            CHECK(now.kinetic < least + 1e-3 * before.kinetic);
            least = std::min(least, now.kinetic);
        }
        collided += touched;
        CHECK(relative(world.mechanics().momentum, before.momentum) < 1e-4);
        // The correction of overlap moves bodies, and with them angular momentum.
        CHECK(glm::length(world.mechanics().angular_momentum - before.angular_momentum) < 2e-2);
    }
    CHECK(collided > 10);
}

TEST_CASE(
    "compound on compound: contacts name the hulls that touch, with the normal from the second body to the first") {
    World world(empty_space);
    BodyDesc left = beam({0.3f, 0.05f, 0.05f}, 3, 3.0f, {}), right = beam({0.3f, 0.05f, 0.05f}, 4, 3.0f, {});
    left.pose.position = {-0.32f, 0.02f, 0.01f};
    right.pose.position = {0.32f, 0.0f, 0.0f};
    left.linear_velocity = {1.0f, 0.0f, 0.0f};
    const BodyId a = must_add(world, left), b = must_add(world, right);
    size_t contacts = 0;
    for (int step = 0; step < 30; ++step) {
        world.step();
        for (const Contact& contact : world.contacts()) {
            ++contacts;
            const bool ordered = contact.a == a;
            CHECK((ordered ? contact.b : contact.a) == b);
            CHECK((ordered ? contact.a : contact.b) == a);
            CHECK((ordered ? contact.part_a : contact.part_b) == 2); // the last of the left beam
            CHECK((ordered ? contact.part_b : contact.part_a) == 0); // the first of the right one
            CHECK((ordered ? -contact.normal.x : contact.normal.x) > 0.99f);
        }
    }
    CHECK(contacts > 0);
    CHECK(world.linear_velocity(b).x > 0.3f);
}

TEST_CASE("compound on compound: what happens is equal for 1, 2 and 4 threads, bit for bit") {
    const auto hashes = [](uint32_t threads) {
        World world({.threads = threads});
        test::Random random(7);
        for (int i = 0; i < 60; ++i) {
            const glm::vec3 at(random.point({-0.5, 0.4, -0.5}, {0.5, 3.0, 0.5}));
            BodyDesc one = i % 2 == 0 ? cross_of_bars(2.0f, at) : beam({0.25f, 0.03f, 0.08f}, 5, 4.0f, at);
            one.angular_velocity = glm::vec3(random.point(glm::dvec3(-4.0), glm::dvec3(4.0)));
            must_add(world, one);
        }
        std::vector<uint64_t> after;
        for (int step = 0; step < 240; ++step) {
            world.step();
            if (step % 20 == 19) after.push_back(world.state_hash());
        }
        CHECK(world.contact_count() > 60);
        return after;
    };
    const std::vector<uint64_t> expected = hashes(1);
    for (const uint32_t threads : {2u, 4u}) {
        CAPTURE(threads);
        CHECK(hashes(threads) == expected);
    }
}
