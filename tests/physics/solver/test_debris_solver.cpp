// Debris meets everything: what it lies on, what it pushes, and how it heaps. Which bodies become debris:
// test_crowd.cpp.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "physics/world/pieces.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"
#include "tests/physics/destruction_fixture.h"
#include "tools/bench/overlap.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;
using namespace brittle::physics::test_destruction;

namespace {

constexpr float half = block_half;

// A cube of 1 m in pieces.
fracture::Fragments broken_cube(uint32_t sites) {
    const fracture::TriangleMesh cube = fracture::cube(1.0);
    auto broken = fracture::fracture(cube, fracture::uniform_sites(fracture::bounds(cube), sites, 5));
    REQUIRE(broken.has_value());
    return *std::move(broken);
}

struct Heap {
    double radius = 0.0;          // m, that holds nineteen pieces of twenty
    std::vector<double> inside{}; // by piece: the largest share of its volume inside another one
    std::vector<double> volumes{};
    uint64_t hash = 0;
    double lowest = 0.0; // m, of the centres
};

Heap heap_of(const fracture::Fragments& pieces, const WorldSettings& settings, float seconds) {
    World world(settings);
    REQUIRE(add_pieces(world, pieces, {}, {.placement = {{0.0f, 0.8f, 0.0f}, {1.0f, 0.0f, 0.0f, 0.0f}}}).has_value());
    run(world, seconds);
    Heap heap{.hash = world.state_hash(), .lowest = 1.0};
    std::vector<tools::HullFeatures> features;
    std::vector<double> ways;
    for (const auto& hull : collision_hulls(pieces)) features.push_back(tools::features_of(*hull));
    const std::vector<Pose> poses = poses_of(world);
    for (size_t i = 0; i < poses.size(); ++i) {
        ways.push_back(std::hypot(poses[i].position.x, poses[i].position.z));
        heap.lowest = std::min(heap.lowest, static_cast<double>(poses[i].position.y));
        heap.volumes.push_back(features[i].volume);
    }
    heap.inside = tools::shares_inside(features, poses);
    std::ranges::sort(ways);
    heap.radius = ways[ways.size() * 95 / 100];
    return heap;
}

} // namespace

TEST_CASE("debris: it lies on the ground, on fixed and moving bodies, and on debris") {
    World world;
    for (const auto& [x, fixed] : {std::pair(2.0f, true), std::pair(4.0f, false)}) {
        BodyDesc floor = box({0.3f, 0.05f, 0.3f}, 50.0f, {x, 0.05f, 0.0f});
        floor.fixed = fixed;
        floor.debris = fixed; // ignored: a fixed body is no debris
        must_add(world, floor);
    }
    std::vector<std::pair<BodyId, float>> blocks; // and the height at which it lies
    for (const auto& [x, floor] : {std::pair(0.0f, 0.0f), std::pair(2.0f, 0.1f), std::pair(4.0f, 0.1f)}) {
        blocks.emplace_back(must_add(world, block({x, floor + half + 0.4f, 0.0f}, true)), floor + half);
        blocks.emplace_back(must_add(world, block({x, floor + half + 0.001f, 0.2f}, true)), floor + half);
    }
    const BodyId below = must_add(world, block({6.0f, half, 0.0f}, true)),
                 above = must_add(world, block({6.0f, 3.2f * half, 0.0f}, true));
    CHECK(world.colliding_count() == 1);
    run(world, 4.0f);
    for (const auto& [id, height] : blocks) {
        CHECK(world.debris(id));
        CHECK(std::abs(world.pose(id).position.y - height) < 2e-3f);
    }
    // As ellipsoids: the one above stands off by up to a fifth of a half, or has rolled off.
    const glm::vec3 way = world.pose(above).position - world.pose(below).position;
    CHECK(glm::length(way) > 2.0f * half);
    CHECK(world.pose(above).position.y > half - 2e-3f);
    CHECK(world.awake_count() == 0);
}

TEST_CASE("debris: it rests on the ground beside its like after what carried it is removed") {
    World world;
    const BodyId table = must_add(world, box({0.3f, 0.05f, 0.3f}, 50.0f, {0.0f, 0.25f, 0.0f}));
    for (const float x : {-0.2f, 0.2f})
        must_add(world, box({0.02f, 0.1f, 0.3f}, 5.0f, {x, 0.1f, 0.0f})); // the legs of the table
    const BodyId debris = must_add(world, block({0.02f, 0.3f + half + 0.01f, 0.01f}, true));
    run(world, 3.0f);
    CHECK(std::abs(world.pose(debris).position.y - 0.3f - half) < 2e-3f);
    CHECK(world.awake_count() == 0);
    REQUIRE(world.remove_body(table));
    CHECK(world.awake(debris));
    run(world, 3.0f);
    CHECK(std::abs(world.pose(debris).position.y - half) < 2e-3f);
    CHECK(world.awake_count() == 0);
}

TEST_CASE("debris: a collision in the void conserves momentum and angular momentum, and gains no energy") {
    test::Random random(5);
    for (int trial = 0; trial < 40; ++trial) {
        CAPTURE(trial);
        World world(empty_space);
        const bool like = trial % 2 == 0; // else the second one is eight times as long, and has a hull
        for (int i = 0; i < 2; ++i) {
            const float side = i == 1 && !like ? 0.4f : 0.05f;
            const glm::vec3 sides = side * glm::vec3(random.point(glm::dvec3(0.6), glm::dvec3(1.4)));
            BodyDesc one = box(sides, 2000.0f * sides.x * sides.y * sides.z, {});
            one.debris = i == 0;
            one.pose.position = glm::vec3(random.point(glm::dvec3(-0.03), glm::dvec3(0.03)));
            one.pose.position.x += i == 0 ? 0.0f : 0.1f + 1.5f * side;
            one.pose.orientation =
                glm::angleAxis(static_cast<float>(random.uniform(0.0, 3.0)), glm::vec3(random.direction()));
            one.linear_velocity = {i == 0 ? static_cast<float>(random.uniform(0.5, 12.0)) : 0.0f, 0.0f, 0.0f};
            one.angular_velocity = glm::vec3(random.direction()) * static_cast<float>(random.uniform(0.0, 5.0));
            must_add(world, one);
        }
        const Mechanics before = world.mechanics(), second = world.mechanics(world.bodies()[1]);
        const glm::vec3 velocity = world.linear_velocity(world.bodies()[1]);
        const float way = glm::length(world.linear_velocity(world.bodies()[0]) - velocity) * world.settings().step;
        double energy = before.kinetic;
        bool met = false;
        for (int i = 0; i < 120; ++i) {
            world.step();
            const Mechanics now = world.mechanics();
            CHECK(now.kinetic <= energy * (1.0 + 3e-5)); // in single precision, a fast rotation keeps five digits
            energy = now.kinetic;
            met = met || world.linear_velocity(world.bodies()[1]) != velocity;
        }
        CHECK(met);
        const Mechanics after = world.mechanics();
        const glm::dvec3 passed_on = world.mechanics(world.bodies()[1]).momentum - second.momentum;
        CHECK(glm::length(after.momentum - before.momentum) < 1e-4 * glm::length(before.momentum));
        // Lever arms are those of the start of a step. The error of an impulse is at most the way in that step times it.
        CHECK(glm::length(after.angular_momentum - before.angular_momentum)
              < 1e-4 * glm::length(before.angular_momentum) + static_cast<double>(way) * glm::length(passed_on));
    }
}

TEST_CASE("debris: a cloud that falls onto the ground gains no energy in any step") {
    World world({.air_density = 0.0f, .sleeping = false});
    test::Random random(8);
    for (int i = 0; i < 150; ++i) {
        const glm::vec3 sides(random.point(glm::dvec3(0.02), glm::dvec3(0.06)));
        BodyDesc one = box(sides, 2000.0f * 8.0f * sides.x * sides.y * sides.z,
                           glm::vec3(random.point({-0.4, 0.1, -0.4}, {0.4, 2.5, 0.4})));
        one.debris = true;
        must_add(world, one);
    }
    // Those that begin inside each other are moved apart, which may lift them.
    run(world, 0.25f);
    const auto energy_of = [](const Mechanics& of) { return of.kinetic + of.potential; };
    const double start = energy_of(world.mechanics());
    double energy = start;
    for (int i = 0; i < 360; ++i) {
        world.step();
        const double now = energy_of(world.mechanics());
        CHECK(now <= energy + 2e-4 * start);
        energy = std::min(energy, now);
    }
    CHECK(world.mechanics().kinetic < 1e-3 * start);
}

TEST_CASE("debris: a heap has no piece deep inside another, and the radius of a heap in which all meet"
          * doctest::test_suite("long")) {
    const fracture::Fragments pieces = broken_cube(500);
    const Heap debris = heap_of(pieces, {.max_colliding = 20}, 4.0f),
               all = heap_of(pieces, {.debris_size = 0.0f, .max_colliding = 0}, 4.0f);
    CHECK(std::abs(debris.radius / all.radius - 1.0) < 0.1);
    CHECK(debris.lowest > -2e-3);
    // Crumbs that are pressed into the ground count in neither heap.
    double mean = 0.0;
    for (const double volume : debris.volumes) mean += volume / static_cast<double>(debris.volumes.size());
    size_t deep = 0;
    for (size_t i = 0; i < debris.inside.size(); ++i) deep += debris.inside[i] > 0.2 && debris.volumes[i] > 0.05 * mean;
    CHECK(deep <= debris.inside.size() / 200);
}

TEST_CASE("debris: runs are equal on any number of threads" * doctest::test_suite("long")) {
    const fracture::Fragments pieces = broken_cube(700);
    const auto hash = [&](uint32_t threads) {
        return heap_of(pieces, {.threads = threads, .max_colliding = 60}, 1.0f).hash;
    };
    const uint64_t one = hash(1);
    for (const uint32_t threads : {2u, 3u, 8u}) CHECK(hash(threads) == one);
}

TEST_CASE("debris: among debris and larger bodies it comes to rest, and wakes when it is struck") {
    World world;
    test::Random random(21);
    for (int i = 0; i < 240; ++i) {
        const glm::vec3 sides(random.point(glm::dvec3(i % 12 == 0 ? 0.1 : 0.02), glm::dvec3(i % 12 == 0 ? 0.2 : 0.06)));
        BodyDesc one = box(sides, 2000.0f * 8.0f * sides.x * sides.y * sides.z,
                           glm::vec3(random.point({-0.6, 0.1, -0.6}, {0.6, 2.0, 0.6})));
        one.debris = i % 12 != 0 && i % 2 == 1;
        must_add(world, one);
    }
    for (float seconds = 0.0f; world.awake_count() > 0 && seconds < 10.0f; seconds += 0.25f) run(world, 0.25f);
    CHECK(world.awake_count() == 0);
    for (const BodyId id : world.bodies()) CHECK(world.pose(id).position.y > 0.015f); // none in the ground
    shoot(world, 0.1f, 20.0f, {0.0f, 2.0f, 0.0f}, {0.0f, -5.0f, 0.0f});
    run(world, 0.6f);
    CHECK(world.awake_count() > 20);
}

TEST_CASE("debris: a heavy body lands on debris and rests on it") {
    World world;
    for (int x = -4; x <= 4; ++x)
        for (int z = -4; z <= 4; ++z) {
            const float height = half + 0.02f * static_cast<float>((x + z) % 2 + 1);
            must_add(world, block({0.125f * static_cast<float>(x), height, 0.125f * static_cast<float>(z)}, true));
        }
    const BodyId slab = must_add(world, box({0.4f, 0.1f, 0.4f}, 200.0f, {0.0f, 0.6f, 0.0f})),
                 load = must_add(world, box({0.2f, 0.1f, 0.2f}, 100.0f, {0.0f, 0.81f, 0.0f}));
    for (float seconds = 0.0f; world.awake_count() > 0 && seconds < 12.0f; seconds += 0.25f) run(world, 0.25f);
    CHECK(world.awake_count() == 0);
    CHECK(std::abs(world.pose(slab).position.y - 2.0f * half - 0.1f) < 0.02f);
    CHECK(std::abs(world.pose(load).position.y - world.pose(slab).position.y - 0.2f) < 5e-3f);
}

TEST_CASE("debris: a ball pushes all debris in its path, and momentum is conserved") {
    World world(empty_space);
    std::vector<std::pair<BodyId, bool>> heap; // and whether it is in the ball's path
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z)
                heap.emplace_back(must_add(world, block(0.3f * glm::vec3(x, y, z), true)), x == 0 && y == 0);
    const BodyId ball = shoot(world, 0.04f, 20.0f, {0.01f, 0.01f, 1.5f}, {0.0f, 0.0f, -12.0f});
    CHECK(world.colliding_count() == 1);
    const Mechanics before = world.mechanics();
    run(world, 0.3f);
    for (const auto& [id, in_the_way] : heap) {
        const float speed = -world.linear_velocity(id).z;
        if (in_the_way)
            CHECK(speed > 3.0f);
        else
            CHECK(speed == 0.0f);
    }
    CHECK(-world.linear_velocity(ball).z < 11.0f);
    const Mechanics after = world.mechanics();
    CHECK(glm::length(after.momentum - before.momentum) < 1e-4 * glm::length(before.momentum));
    CHECK(after.kinetic <= before.kinetic);
}

TEST_CASE("debris: a body on a rope meets it") {
    World world;
    std::vector<BodyId> blocks;
    for (int y = 0; y < 3; ++y)
        blocks.push_back(must_add(world, block({0.0f, half + 0.13f * static_cast<float>(y), 0.0f}, true)));
    BodyDesc bob = box(glm::vec3(0.1f), 40.0f, {1.0f, 1.15f, 0.0f});
    const BodyId swings = must_add(world, bob);
    const glm::vec3 hook(0.0f, 1.15f, 0.0f);
    REQUIRE(world
                .add_joint({.kind = JointKind::distance,
                            .a = swings,
                            .anchor_a = world.pose(swings).position,
                            .anchor_b = hook,
                            .max_length = 1.0f})
                .has_value());
    run(world, 1.0f);
    CHECK(world.pose(blocks[0]).position.x < -0.2f);
    CHECK(glm::length(world.pose(swings).position - hook) < 1.02f);
}
