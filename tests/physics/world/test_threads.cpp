// Results do not depend on threads, bit for bit: neither on the threads that share a step nor on Worlds that step at
// the same time on others.
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "physics/world/world.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

glm::vec3 point_in(test::Random& random, const glm::vec3& low, const glm::vec3& high) {
    return glm::vec3(random.point(glm::dvec3(low), glm::dvec3(high)));
}

// A cloud of boxes that falls into a heap; some are debris.
void add_cloud(World& world, test::Random& random, int count) {
    for (int i = 0; i < count; ++i) {
        BodyDesc one = box(point_in(random, glm::vec3(0.008f), glm::vec3(0.09f)), 1.0f,
                           point_in(random, {-0.7f, 0.1f, -0.7f}, {0.7f, 1.6f, 0.7f}));
        one.angular_velocity = point_in(random, glm::vec3(-5.0f), glm::vec3(5.0f));
        must_add(world, one);
    }
}

// Two tables of two hulls each, one fixed and one free.
void add_tables(World& world) {
    for (const bool fixed : {true, false}) {
        const glm::vec3 half(0.6f, 0.02f, 0.4f);
        BodyDesc table = in_slabs(box(half, 20.0f, {fixed ? -0.4f : 0.5f, 0.5f, 0.0f}), half, 2);
        table.fixed = fixed;
        must_add(world, table);
    }
}

// Compounds among the other bodies, light and heavy in turns.
void add_compounds(World& world, test::Random& random, int count) {
    for (int i = 0; i < count; ++i) {
        const glm::vec3 half(0.2f, 0.03f, 0.1f);
        const glm::vec3 place = point_in(random, {-0.7f, 0.1f, -0.7f}, {0.7f, 1.6f, 0.7f});
        BodyDesc compound = in_slabs(box(half, i % 2 == 0 ? 1.0f : 20.0f, place), half, 5);
        compound.linear_velocity = point_in(random, glm::vec3(-4.0f), glm::vec3(4.0f));
        compound.angular_velocity = point_in(random, glm::vec3(-5.0f), glm::vec3(5.0f));
        must_add(world, compound);
    }
}

// Fast boxes, light and heavy, from all sides.
void shoot(World& world, test::Random& random, int count) {
    for (int i = 0; i < count; ++i) {
        const glm::vec3 from(random.direction() * 2.5);
        BodyDesc shot = box(glm::vec3(0.03f), i % 2 == 0 ? 0.2f : 8.0f, {from.x, std::abs(from.y) + 0.2f, from.z});
        shot.linear_velocity = (glm::vec3(0.0f, 0.4f, 0.0f) - shot.pose.position) * 12.0f;
        must_add(world, shot);
    }
}

// The state hashes of every tenth step of a run.
std::vector<uint64_t> story(uint32_t threads, uint64_t seed = 5, int steps = 150) {
    World world({.threads = threads});
    test::Random random(seed);
    add_tables(world);
    add_cloud(world, random, 400);
    add_compounds(world, random, 16);
    std::vector<uint64_t> hashes;
    for (int i = 0; i < steps; ++i) {
        if (i == 30) shoot(world, random, 60);
        if (i == 60) // every third body is removed
            for (size_t k = 2; k < world.body_count(); k += 2) CHECK(world.remove_body(world.bodies()[k]));
        if (i == 61) add_cloud(world, random, 100);
        world.step();
        if (i % 10 == 9) hashes.push_back(world.state_hash());
    }
    return hashes;
}

} // namespace

TEST_CASE("threads: a run does not depend on the number of threads that share a step") {
    const std::vector<uint64_t> alone = story(1);
    CHECK(alone.front() != alone.back());
    for (const uint32_t threads : {2u, 3u, 8u, 0u}) {
        INFO("threads: ", threads);
        CHECK(story(threads) == alone);
    }
}

TEST_CASE("threads: two worlds stepped at the same time have the hashes of one after the other") {
    constexpr int steps = 70; // until all kinds of bodies have been added, and some removed
    const std::vector<uint64_t> first = story(1, 5, steps), second = story(1, 6, steps);
    CHECK(first != second);
    for (const uint32_t threads : {1u, 2u}) { // of each world
        INFO("threads: ", threads);
        std::vector<uint64_t> beside_first, beside_second;
        {
            const std::jthread other([&] { beside_second = story(threads, 6, steps); });
            beside_first = story(threads, 5, steps);
        }
        CHECK(beside_first == first);
        CHECK(beside_second == second);
    }
}

TEST_CASE("threads: worlds are created, stepped, cleared and destroyed on several threads at the same time") {
    // Also of the same shared hull.
    const auto hull = std::make_shared<const CollisionHull>(box_hull(glm::vec3(0.05f)));
    const auto short_story = [&hull](uint64_t seed) {
        test::Random random(seed);
        World world({.threads = 2});
        uint64_t hash = 0;
        for (int round = 0; round < 3; ++round) {
            add_cloud(world, random, 40);
            for (int i = 0; i < 10; ++i) {
                BodyDesc pair = box(glm::vec3(0.05f), 1.0f, point_in(random, {-0.7f, 0.1f, -0.7f}, {0.7f, 1.6f, 0.7f}));
                pair.parts = {{hull, {-0.05f, 0.0f, 0.0f}}, {hull, {0.05f, 0.0f, 0.0f}}};
                pair.inertia = box_inertia({0.1f, 0.05f, 0.05f}, 1.0f);
                must_add(world, pair);
            }
            for (int step = 0; step < 20; ++step) world.step();
            hash = hash * 31 + world.state_hash();
            world.clear();
        }
        return hash;
    };
    constexpr uint64_t worlds = 12;
    std::vector<uint64_t> expected(worlds), found(worlds);
    for (uint64_t seed = 0; seed < worlds; ++seed) expected[seed] = short_story(seed);
    {
        std::atomic<uint64_t> next = 0;
        std::vector<std::jthread> threads;
        for (int i = 0; i < 4; ++i)
            threads.emplace_back([&] {
                for (uint64_t seed = next++; seed < worlds; seed = next++) found[seed] = short_story(seed);
            });
    }
    CHECK(found == expected);
}

TEST_CASE("threads: a world may be created on one thread, stepped on a second and destroyed on a third") {
    std::vector<uint64_t> hashes(2);
    for (const bool moved : {false, true}) {
        std::unique_ptr<World> world;
        const auto on = [moved](const auto& what) {
            if (moved)
                std::jthread(what).join();
            else
                what();
        };
        test::Random random(4);
        on([&] { world = std::make_unique<World>(WorldSettings{.threads = 2}); });
        on([&] { add_cloud(*world, random, 60); });
        on([&] { run(*world, 0.5f); });
        hashes[moved ? 1 : 0] = world->state_hash();
        on([&] { world.reset(); });
    }
    CHECK(hashes[0] == hashes[1]);
}
