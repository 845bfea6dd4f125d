// Continuous collision: small and fast bodies do not pass through thin ones, a blow is one whole impulse, and bodies
// that only fly past are left alone.
#include "physics/world/world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "physics/world/pieces.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

// A box of 1000 kg/m^3, of one hull or of several slabs along x.
BodyDesc made_of(const glm::vec3& half, int parts) {
    const BodyDesc desc = box(half, 8000.0f * half.x * half.y * half.z, {});
    return parts == 1 ? desc : in_slabs(desc, half, parts);
}

glm::vec3 any(test::Random& random, float length) {
    return length * glm::vec3(random.point(glm::dvec3(-1.0), glm::dvec3(1.0)));
}

glm::quat any_turn(test::Random& random) {
    return glm::normalize(glm::quat(1.1f, any(random, 1.0f)));
}

struct Shot {
    float slab = 0.0f;   // half of the slab's thickness, m
    float size = 0.0f;   // of the box, m
    float speed = 0.0f;  // m/s
    bool tilted = false; // the slab
    // 0 .. 8: 0 to 2 parallel to the slab, 3 to 5 rotated, 6 to 8 rotated and spinning; every third one flies
    // obliquely.
    int place = 0;
    int slab_parts = 1, parts = 1;
};

// Whether the box comes out behind the slab or ends inside it.
bool passes(const Shot& shot) {
    test::Random random(static_cast<uint64_t>(shot.place) + 9u * static_cast<uint64_t>(shot.speed));
    World world({.ground_height = std::nullopt});
    BodyDesc slab = made_of({0.5f, shot.slab, 0.5f}, shot.slab_parts);
    slab.fixed = true;
    slab.pose.orientation = glm::angleAxis(shot.tilted ? 0.35f : 0.0f, glm::vec3(0.0f, 0.0f, 1.0f));
    must_add(world, slab);
    BodyDesc fly = made_of(0.5f * shot.size * glm::vec3(1.0f, 0.7f, 0.8f), shot.parts);
    const float above = shot.slab + 2.0f * shot.size;
    const glm::vec3 aim = shot.place % 3 == 2 ? glm::vec3(0.7f, -1.0f, 0.0f) : glm::vec3(0.0f, -1.0f, 0.0f);
    glm::vec3 start =
        glm::vec3(0.0f, above, 0.0f) - aim * (shot.speed / 120.0f * (1.0f + std::abs(any(random, 1.0f).x)));
    start += glm::vec3(0.15f, 0.0f, 0.15f) * any(random, 1.0f) - above * glm::vec3(aim.x, 0.0f, 0.0f);
    fly.pose.position = slab.pose.orientation * start;
    fly.pose.orientation = shot.place >= 3 ? any_turn(random) : slab.pose.orientation;
    if (shot.place >= 6) fly.angular_velocity = any(random, 30.0f);
    fly.linear_velocity = slab.pose.orientation * (shot.speed * glm::normalize(aim));
    const BodyId id = must_add(world, fly);
    const auto in_slab = [&] { return glm::conjugate(slab.pose.orientation) * world.pose(id).position; };
    for (int step = 0; step < 60; ++step) {
        world.step();
        const glm::vec3 at = in_slab();
        if (std::abs(at.x) < 0.5f && std::abs(at.z) < 0.5f && at.y < -shot.slab) return true;
    }
    const glm::vec3 at = in_slab();
    return std::abs(at.x) < 0.5f && std::abs(at.z) < 0.5f && at.y < shot.slab;
}

} // namespace

// 2,160 shots; without continuous collision half of them pass.
TEST_CASE(
    "continuous collision: boxes of 1 to 5 cm neither pass through fixed slabs of 2 and 10 cm nor stay inside them") {
    struct Kind {
        int slab_parts, parts;
    };
    for (const Kind kind : {Kind{1, 1}, {5, 1}, {5, 2}}) {
        int passed = 0;
        for (const float slab : {0.01f, 0.05f})
            for (const float size : {0.01f, 0.02f, 0.03f, 0.04f, 0.05f})
                for (const float speed : {2.0f, 5.0f, 10.0f, 20.0f})
                    for (const bool tilted : {false, true})
                        for (int place = 0; place < 9; ++place)
                            passed += passes({slab, size, speed, tilted, place, kind.slab_parts, kind.parts}) ? 1 : 0;
        CAPTURE(kind.slab_parts);
        CAPTURE(kind.parts);
        CHECK(passed == 0);
    }
}

TEST_CASE("continuous collision: a fast ball does not pass through a thin wall, fixed or free, and its blow is one "
          "whole impulse") {
    for (const float speed : {20.0f, 80.0f, 200.0f}) // up to 1.67 m a step
        for (const bool fixed : {false, true})
            for (const int parts : {1, 2})
                for (int place = 0; place < 8; ++place) {
                    World world(empty_space);
                    BodyDesc wall = made_of({0.5f, 0.5f, 0.01f}, parts);
                    wall.mass = 100.0f;
                    wall.inertia = box_inertia({0.5f, 0.5f, 0.01f}, 100.0f);
                    wall.fixed = fixed;
                    const BodyId held = must_add(world, wall);
                    BodyDesc ball = made_of(glm::vec3(0.025f), parts);
                    ball.mass = 1.0f;
                    ball.inertia = box_inertia(glm::vec3(0.025f), 1.0f);
                    ball.pose.position = {0.1f, 0.05f, 2.0f + 0.2f * static_cast<float>(place)};
                    ball.linear_velocity = {0.0f, 0.0f, -speed};
                    const BodyId id = must_add(world, ball);
                    float blow = 0.0f;
                    for (int step = 0; step < 30; ++step) {
                        world.step();
                        float sum = 0.0f;
                        for (const Contact& contact : world.contacts()) sum += contact.impulse;
                        blow = std::max(blow, sum);
                    }
                    CAPTURE(speed);
                    CAPTURE(fixed);
                    CAPTURE(parts);
                    CAPTURE(place);
                    CHECK(world.pose(id).position.z > world.pose(held).position.z);
                    // In one step at least the impulse that stops 1 kg; against 100 kg that may rotate, 0.8 of it.
                    CHECK(blow > (fixed ? 0.99f : 0.8f) * speed);
                }
}

TEST_CASE(
    "continuous collision: a box that falls flat bounces with its whole speed, at any time of impact within a step") {
    for (const float speed : {5.0f, 20.0f})
        for (int place = 0; place < 10; ++place) {
            World world(empty_space);
            BodyDesc slab = made_of({0.5f, 0.01f, 0.5f}, 1);
            slab.fixed = true;
            slab.restitution = 0.8f;
            must_add(world, slab);
            BodyDesc fall = made_of(glm::vec3(0.02f), 1);
            fall.pose.position = {0.1f, 0.05f + speed / 120.0f * (1.0f + 0.1f * static_cast<float>(place)), 0.0f};
            fall.linear_velocity = {0.0f, -speed, 0.0f};
            fall.restitution = 0.8f;
            const BodyId id = must_add(world, fall);
            run(world, 0.1f);
            CAPTURE(speed);
            CAPTURE(place);
            CHECK(world.linear_velocity(id).y == doctest::Approx(0.64 * static_cast<double>(speed)).epsilon(1e-3));
            CHECK(glm::length(world.angular_velocity(id)) < 1e-2f * speed);
        }
}

TEST_CASE("continuous collision: a body that flies past an edge moves as in an empty world, bit for bit") {
    for (const float gap : {1e-2f, 1e-3f, 1e-4f})
        for (const float speed : {5.0f, 20.0f, 80.0f})
            for (const bool turned : {false, true})
                for (int place = 0; place < 4; ++place) {
                    World empty(empty_space), with(empty_space);
                    BodyDesc slab = made_of({0.5f, 0.01f, 0.5f}, place % 2 == 0 ? 1 : 5);
                    slab.fixed = true;
                    BodyDesc fly = made_of(glm::vec3(0.01f), 1);
                    const float aside = turned ? 0.01f * std::sqrt(2.0f) : 0.01f;
                    fly.pose.position = {0.5f + aside + gap, 0.3f + 0.01f * static_cast<float>(place), 0.1f};
                    if (turned) fly.pose.orientation = glm::angleAxis(0.7853982f, glm::vec3(0.0f, 0.0f, 1.0f));
                    fly.linear_velocity = {0.0f, -speed, 0.0f};
                    must_add(with, slab);
                    const BodyId beside = must_add(with, fly), alone = must_add(empty, fly);
                    run(with, 0.2f);
                    run(empty, 0.2f);
                    CAPTURE(gap);
                    CAPTURE(speed);
                    CAPTURE(turned);
                    CHECK(with.linear_velocity(beside) == empty.linear_velocity(alone));
                    CHECK(with.angular_velocity(beside) == empty.angular_velocity(alone));
                    CHECK(with.pose(beside).position == empty.pose(alone).position);
                }
}

TEST_CASE("continuous collision: pieces that fly apart do not stop each other") {
    World world(empty_space);
    const auto fragments = test::voronoi_pieces({-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2}, 80, 5);
    const Result<std::vector<BodyId>> bodies = add_pieces(world, fragments, {});
    REQUIRE(bodies);
    std::vector<glm::vec3> start;
    for (const BodyId id : *bodies) {
        start.push_back(world.pose(id).position);
        world.set_velocity(id, 100.0f * start.back(), {}); // up to 35 m/s
    }
    for (int step = 0; step < 12; ++step) world.step();
    for (size_t i = 0; i < bodies->size(); ++i)
        CHECK(glm::length(world.pose((*bodies)[i]).position - 11.0f * start[i]) < 1e-3f);
}

TEST_CASE("continuous collision: a fast body that slides is not stopped by the joints of the floor") {
    World world({.ground_height = std::nullopt, .air_density = 0.0f});
    BodyDesc floor = made_of({50.0f, 0.1f, 1.0f}, 100);
    floor.fixed = true;
    floor.friction = 0.0f;
    floor.pose.position.y = -0.1f;
    must_add(world, floor);
    BodyDesc puck = made_of(glm::vec3(0.05f), 1);
    puck.pose.position = {-40.0f, 0.05f, 0.0f};
    puck.linear_velocity = {30.0f, 0.0f, 0.0f};
    const BodyId id = must_add(world, puck);
    run(world, 1.0f);
    CHECK(world.pose(id).position.x == doctest::Approx(-10.0).epsilon(0.01));
}

TEST_CASE("continuous collision: a heavy ball flies on through a cloud of light pieces") {
    World world(empty_space);
    test::Random random(3);
    for (int i = 0; i < 200; ++i) {
        BodyDesc piece = made_of({0.03f, 0.01f, 0.03f}, 1);
        piece.pose = {glm::vec3(0.0f, 0.0f, -0.5f) + any(random, 0.4f), any_turn(random)};
        must_add(world, piece);
    }
    BodyDesc ball = made_of(glm::vec3(0.06f), 1);
    ball.mass = 20.0f;
    ball.inertia = box_inertia(glm::vec3(0.06f), 20.0f);
    ball.pose.position = {0.0f, 0.0f, 1.0f};
    ball.linear_velocity = {0.0f, 0.0f, -40.0f};
    const BodyId id = must_add(world, ball);
    const Mechanics before = world.mechanics();
    run(world, 0.2f); // 8 m in an empty world
    CHECK(world.pose(id).position.z < -4.0f);
    CHECK(world.mechanics().kinetic < before.kinetic * 1.0001);
    CHECK(glm::length(world.mechanics().momentum - before.momentum) < 1e-4 * glm::length(before.momentum));
}

namespace {

// Nine tiles in the path of a heavy block three times as wide, and the block, after it has pushed them along.
struct Driven {
    // In units of the block's initial speed: the tiles' speeds along its path, the speeds of their rims from their
    // spin, the mean of the former, and the block's own final speed.
    std::vector<float> speeds, turns;
    float mean = 0.0f, block = 0.0f;

    Driven(float speed, int place, bool tilted, int substeps) {
        WorldSettings settings = empty_space;
        settings.step /= static_cast<float>(substeps);
        World world(settings);
        test::Random random(5);
        std::vector<BodyId> hit;
        for (int x = -3; x <= 3; ++x)
            for (int y = -3; y <= 3; ++y) {
                BodyDesc tile = made_of({0.024f, 0.024f, 0.01f}, 1);
                tile.mass = 0.1f;
                tile.inertia = box_inertia({0.024f, 0.024f, 0.01f}, 0.1f);
                tile.pose.position =
                    (tilted ? 0.065f : 0.05f) * glm::vec3(static_cast<float>(x), static_cast<float>(y), 0.0f);
                if (tilted) tile.pose.orientation = glm::normalize(glm::quat(1.0f, any(random, 0.15f)));
                const BodyId id = must_add(world, tile);
                if (std::abs(x) <= 1 && std::abs(y) <= 1) hit.push_back(id);
            }
        BodyDesc heavy = made_of(glm::vec3(0.07f), 1);
        heavy.mass = 17.0f;
        heavy.inertia = box_inertia(glm::vec3(0.07f), 17.0f);
        heavy.pose.position = {0.0f, 0.0f, 0.5f + 0.03f * static_cast<float>(place)};
        heavy.linear_velocity = {0.0f, 0.0f, -speed};
        const BodyId id = must_add(world, heavy);
        const Mechanics before = world.mechanics();
        run(world, 0.7f / speed + 0.05f);
        for (const BodyId tile : hit) {
            speeds.push_back(-world.linear_velocity(tile).z / speed);
            turns.push_back(0.024f * glm::length(world.angular_velocity(tile)) / speed);
            mean += speeds.back() / 9.0f;
        }
        block = -world.linear_velocity(id).z / speed;
        CHECK(world.pose(id).position.z < -0.04f * speed);
        CHECK(glm::length(world.mechanics().momentum - before.momentum) < 1e-4 * glm::length(before.momentum));
        CHECK(world.mechanics().kinetic < before.kinetic * 1.0001);
    }
};

} // namespace

// The oracle is the same run in steps of 1/1920 s. The bounds were set from measured errors. With contacts at the
// nearest point alone, flat tiles got 0.3 to 1.1 of the speed, and tilted ones 0.24 to 0.71 of it on average.
TEST_CASE(
    "continuous collision: a heavy block pushes the light tiles in its path as in fine steps, and is not stopped") {
    for (const float speed : {10.0f, 20.0f, 60.0f})
        for (const bool tilted : {false, true}) {
            const Driven fine(speed, 0, tilted, 16);
            CHECK(fine.mean > 0.9f);
            for (int place = 0; place < 6; ++place) {
                CAPTURE(speed);
                CAPTURE(tilted);
                CAPTURE(place);
                const Driven driven(speed, place, tilted, 1);
                CHECK(std::abs(driven.mean - fine.mean) < (tilted ? 0.23f : 0.07f));
                CHECK(std::abs(driven.block - fine.block) < 0.02f);
                if (tilted) continue;
                for (const float tile : driven.speeds) CHECK(std::abs(tile - fine.mean) < 0.1f);
                for (const float turn : driven.turns) CHECK(turn < 0.03f);
            }
        }
}

namespace {

// A box at rest, and a box of `ratio` times its size that strikes it and moves by `way` times its thickness a step.
struct Struck {
    glm::vec3 velocity{0.0f}; // of the box that was at rest, in units of the other's speed
    bool passed = false;

    Struck(float size, float way, float ratio, int place, int substeps) {
        test::Random random(static_cast<uint64_t>(place) + 100u * static_cast<uint64_t>(std::lround(10.0f * way)));
        WorldSettings settings = empty_space;
        settings.step /= static_cast<float>(substeps);
        World world(settings);
        const glm::vec3 half = 0.5f * size * glm::vec3(1.0f, 0.7f, 0.8f);
        BodyDesc rest = made_of(half, 1), fly = made_of(ratio * half, 1);
        const float speed = way * 0.7f * size * 120.0f;
        fly.linear_velocity = {0.0f, -speed, 0.0f};
        fly.pose.position.y = 2.0f * size + speed / 120.0f * (1.0f + std::abs(any(random, 1.0f).x));
        fly.pose.position += 0.2f * size * glm::vec3(1.0f, 0.0f, 1.0f) * any(random, 1.0f);
        if (place % 3 >= 1) rest.pose.orientation = any_turn(random), fly.pose.orientation = any_turn(random);
        if (place % 3 == 2) rest.angular_velocity = any(random, 20.0f), fly.angular_velocity = any(random, 20.0f);
        const BodyId resting = must_add(world, rest), flying = must_add(world, fly);
        const Mechanics before = world.mechanics();
        for (int step = 0; step < 30 * substeps; ++step) {
            world.step();
            const glm::vec3 apart = world.pose(flying).position - world.pose(resting).position;
            passed = passed || (std::max(std::abs(apart.x), std::abs(apart.z)) < 0.5f * size && apart.y < -0.1f * size);
        }
        velocity = world.linear_velocity(resting) / speed;
        CHECK(glm::length(world.mechanics().momentum - before.momentum) < 1e-4 * glm::length(before.momentum));
        CHECK(world.mechanics().kinetic < before.kinetic * 1.0001);
    }
};

} // namespace

// 480 shots each. Without speculative contacts between boxes of similar mass, 118 and 119 passed through, and the
// velocity of the struck box was wrong by a tenth of the other's speed on average. The bounds were set from measured
// errors.
TEST_CASE("continuous collision: boxes of similar mass do not pass through each other, and strike as in fine steps") {
    for (const auto& [case_ratio, max_passed] : {std::pair(1.0f, 3), {0.8f, 1}}) { // 0.8: half of the mass
        const auto ratio = case_ratio; // clang 14 captures no structured binding
        int passed = 0;
        float error = 0.0f;
        for (const float way : {0.3f, 0.5f, 0.7f, 0.9f, 1.1f, 1.3f, 1.6f, 1.9f})
            for (int place = 0; place < 60; ++place) {
                const Struck coarse(0.05f, way, ratio, place, 1), fine(0.05f, way, ratio, place, 16);
                passed += coarse.passed ? 1 : 0;
                CHECK_FALSE(fine.passed);
                error += glm::length(coarse.velocity - fine.velocity) / 480.0f;
            }
        CAPTURE(ratio);
        MESSAGE(passed, " of 480 passed, mean error ", error);
        CHECK(passed <= max_passed);
        CHECK(error < 0.055f);
    }
}
