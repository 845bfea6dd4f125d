// A step on several threads is the step on one, bit for bit.
#include <cmath>
#include <cstdint>
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

// Boxes in a cloud that falls and gets into a heap; some are debris.
void add_cloud(World& world, test::Random& random, int count) {
    for (int i = 0; i < count; ++i) {
        BodyDesc one = box(point_in(random, glm::vec3(0.008f), glm::vec3(0.09f)), 1.0f,
                           point_in(random, {-0.7f, 0.1f, -0.7f}, {0.7f, 1.6f, 0.7f}));
        one.angular_velocity = point_in(random, glm::vec3(-5.0f), glm::vec3(5.0f));
        must_add(world, one);
    }
}

// A table of two hulls, fixed, and one that can be pushed.
void add_tables(World& world) {
    for (const bool fixed : {true, false}) {
        const glm::vec3 half(0.6f, 0.02f, 0.4f);
        BodyDesc table = in_slabs(box(half, 20.0f, {fixed ? -0.4f : 0.5f, 0.5f, 0.0f}), half, 2);
        table.fixed = fixed;
        must_add(world, table);
    }
}

// What is left of things that broke: bodies of several hulls amidst the others.
void add_rests(World& world, test::Random& random, int count) {
    for (int i = 0; i < count; ++i) {
        const glm::vec3 half(0.2f, 0.03f, 0.1f);
        const glm::vec3 place = point_in(random, {-0.7f, 0.1f, -0.7f}, {0.7f, 1.6f, 0.7f});
        BodyDesc rest = in_slabs(box(half, i % 2 == 0 ? 1.0f : 20.0f, place), half, 5);
        rest.linear_velocity = point_in(random, glm::vec3(-4.0f), glm::vec3(4.0f));
        rest.angular_velocity = point_in(random, glm::vec3(-5.0f), glm::vec3(5.0f));
        must_add(world, rest);
    }
}

// Fast ones, light and heavy, from all sides.
void shoot(World& world, test::Random& random, int count) {
    for (int i = 0; i < count; ++i) {
        const glm::vec3 from(random.direction() * 2.5);
        BodyDesc shot = box(glm::vec3(0.03f), i % 2 == 0 ? 0.2f : 8.0f, {from.x, std::abs(from.y) + 0.2f, from.z});
        shot.linear_velocity = (glm::vec3(0.0f, 0.4f, 0.0f) - shot.pose.position) * 12.0f;
        must_add(world, shot);
    }
}

// Hashes of all that happens, every tenth step.
std::vector<uint64_t> story(uint32_t threads) {
    World world({.threads = threads});
    test::Random random(5);
    add_tables(world);
    add_cloud(world, random, 400);
    add_rests(world, random, 16);
    std::vector<uint64_t> hashes;
    for (int i = 0; i < 150; ++i) {
        if (i == 30) shoot(world, random, 60);
        if (i == 60) // every third goes
            for (size_t k = 2; k < world.body_count(); k += 2) CHECK(world.remove_body(world.bodies()[k]));
        if (i == 61) add_cloud(world, random, 100);
        world.step();
        if (i % 10 == 9) hashes.push_back(world.state_hash());
    }
    return hashes;
}

} // namespace

TEST_CASE("what happens does not depend on the number of threads") {
    const std::vector<uint64_t> alone = story(1);
    CHECK(alone.front() != alone.back());
    for (const uint32_t threads : {2u, 3u, 8u, 0u}) {
        INFO("threads: ", threads);
        CHECK(story(threads) == alone);
    }
}
