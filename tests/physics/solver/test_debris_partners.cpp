// The bodies that debris collides with: it lies on them and is pushed by them, and falls through all others. Which
// bodies become debris: test_crowd.cpp.
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"
#include "tests/physics/destruction_fixture.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;
using namespace brittle::physics::test_destruction;

namespace {

constexpr float half = block_half;

} // namespace

TEST_CASE("debris: of any size it falls through debris, but lies on the ground, on fixed and on colliding bodies") {
    World world;
    for (const auto& [x, fixed] : {std::pair(2.0f, true), std::pair(4.0f, false)}) {
        BodyDesc floor = box({0.3f, 0.05f, 0.3f}, 50.0f, {x, 0.05f, 0.0f});
        floor.fixed = fixed;
        floor.debris = fixed; // ignored: a fixed body is no debris
        must_add(world, floor);
    }
    std::vector<BodyId> blocks;
    for (const auto& [x, floor] : {std::pair(0.0f, 0.0f), std::pair(2.0f, 0.1f), std::pair(4.0f, 0.1f)})
        for (const float gap : {0.001f, 0.4f})
            blocks.push_back(must_add(world, block({x, floor + half + gap, 0.0f}, true)));
    CHECK(world.colliding_count() == 1);
    run(world, 3.0f);
    for (size_t i = 0; i < blocks.size(); ++i) {
        CAPTURE(i);
        CHECK(world.debris(blocks[i]));
        CHECK(std::abs(world.pose(blocks[i]).position.y - (i < 2 ? half : 0.1f + half)) < 2e-3f);
    }
    CHECK(world.awake_count() == 0);
}

TEST_CASE("debris: it lies on bodies twice as long and falls through shorter ones, in either order of addition") {
    // Plates on the ground, and above each a block of debris, 10 cm long. By plate: its longest side, and whether it
    // carries.
    for (const bool debris_first : {false, true}) {
        World world;
        std::vector<BodyId> plates, blocks;
        const std::pair<float, bool> lengths[] = {
            {0.05f, false}, {0.1f, false}, {0.199f, false}, {0.201f, true}, {0.5f, true}};
        float x = 0.0f;
        for (const auto& [length, carries] : lengths) {
            BodyDesc plate = box({length / 2.0f, 0.02f, 0.45f * length}, 5.0f, {x, 0.02f, 0.0f});
            plate.pose.orientation = glm::angleAxis(x, glm::vec3(0.0f, 1.0f, 0.0f)); // in any orientation
            if (!debris_first) plates.push_back(must_add(world, plate));
            blocks.push_back(must_add(world, block({x, 0.2f, 0.0f}, true)));
            if (debris_first) plates.push_back(must_add(world, plate));
            x += 1.0f;
        }
        std::vector<Pose> before;
        for (const BodyId plate : plates) before.push_back(world.pose(plate));
        run(world, 2.0f);
        for (size_t i = 0; i < plates.size(); ++i) {
            CAPTURE(i);
            const glm::vec3 at = world.pose(blocks[i]).position;
            CHECK(std::abs(at.y - half - (lengths[i].second ? 0.04f : 0.0f)) < 2e-3f);
            CHECK(glm::length(world.pose(plates[i]).position - before[i].position) < 1e-3f);
        }
        CHECK(world.awake_count() == 0);
    }
}

TEST_CASE("debris: the length of a compound is that of all its hulls together") {
    World world;
    const glm::vec3 beam(0.15f, 0.02f, 0.05f);
    must_add(world, in_slabs(box(beam, 5.0f, {0.0f, 0.02f, 0.0f}), beam, 5)); // its slabs are shorter than a block
    must_add(world, in_slabs(box(beam, 5.0f, {1.0f, 0.02f, 0.0f}), beam, 5));
    BodyDesc long_debris = in_slabs(box({0.16f, 0.02f, 0.02f}, 1.0f, {1.0f, 0.2f, 0.0f}), {0.16f, 0.02f, 0.02f}, 8);
    long_debris.debris = true;
    const BodyId lies = must_add(world, block({0.0f, 0.2f, 0.0f}, true)), falls = must_add(world, long_debris);
    run(world, 2.0f);
    CHECK(std::abs(world.pose(lies).position.y - 0.04f - half) < 2e-3f);
    CHECK(std::abs(world.pose(falls).position.y - 0.02f) < 2e-3f);
    CHECK(world.awake_count() == 0);
}

TEST_CASE("debris: a moving body pushes debris if it is twice as long, and passes through it else, at any speed") {
    for (const float speed : {0.5f, 5.0f, 50.0f}) {
        CAPTURE(speed);
        World world(empty_space);
        std::vector<std::pair<BodyId, BodyId>> rows; // the flying body and its target
        for (const float length : {0.1f, 0.19f, 0.21f, 0.6f}) {
            const float x = 2.0f * static_cast<float>(rows.size());
            BodyDesc flies = box({length / 2.0f, 0.05f, 0.05f}, 4.0f, {x, 0.0f, 0.5f});
            flies.linear_velocity = {0.0f, 0.0f, -speed};
            const BodyId struck = must_add(world, block({x, 0.0f, 0.0f}, true));
            rows.emplace_back(must_add(world, flies), struck);
        }
        const Mechanics before = world.mechanics();
        size_t contacts = 0;
        for (float way = 0.0f; way < 1.5f; way += speed / 120.0f) {
            world.step();
            for (const Contact& contact : world.contacts())
                contacts += contact.a == rows[0].second || contact.b == rows[0].second || contact.a == rows[1].second
                            || contact.b == rows[1].second;
        }
        CHECK(contacts == 0);
        for (size_t i = 0; i < rows.size(); ++i) {
            CAPTURE(i);
            const glm::vec3 flies = world.linear_velocity(rows[i].first),
                            struck = world.linear_velocity(rows[i].second);
            if (i < 2) {
                CHECK(flies == glm::vec3(0.0f, 0.0f, -speed));
                CHECK(struck == glm::vec3(0.0f));
            } else { // 1 kg, struck by 4 kg
                CHECK(-struck.z > 0.75f * speed);
                CHECK(-flies.z < 0.85f * speed);
            }
        }
        const Mechanics after = world.mechanics();
        CHECK(glm::length(after.momentum - before.momentum) < 1e-4 * glm::length(before.momentum));
        CHECK(after.kinetic <= before.kinetic);
    }
}

TEST_CASE("debris: added to a crowd of debris, it falls through bodies that carry earlier debris") {
    struct Plate {
        float length;
        bool large, fixed;
    };
    const Plate plates[] = {{0.25f, false, false}, {0.39f, false, false}, {0.41f, false, false}, {0.79f, false, false},
                            {0.81f, false, false}, {0.12f, true, false},  {0.3f, false, true}};
    // The number of pieces of debris far away, and the length of plate below which a new block then falls through. The
    // crowd counts 14 blocks more: those that lie on the plates and those that are added.
    for (const auto& [case_others, longest] :
         {std::pair(0, 0.2f), std::pair(6, 0.2f), std::pair(16, 0.4f), std::pair(36, 0.8f)}) {
        // clang 14 captures no structured binding
        const auto others = case_others;
        for (const bool sleeping : {false, true}) { // the crowd, before the blocks are added
            CAPTURE(others);
            CAPTURE(sleeping);
            World world({.max_colliding = 10});
            std::vector<BodyId> lie;
            for (size_t i = 0; i < std::size(plates); ++i) {
                const auto& [length, large, fixed] = plates[i];
                BodyDesc plate =
                    box({length / 2.0f, 0.02f, length / 2.0f}, 20.0f, {static_cast<float>(2 * i), 0.02f, 0.0f});
                plate.large = large;
                plate.fixed = fixed;
                must_add(world, plate);
                lie.push_back(must_add(world, block({static_cast<float>(2 * i), 0.04f + half, 0.0f},
                                                    true))); // added before there is a crowd
            }
            std::vector<BodyDesc> crowd, blocks;
            for (int i = 0; i < others; ++i) crowd.push_back(block({static_cast<float>(i), half, 9.0f}, true));
            REQUIRE(world.add_bodies(crowd).has_value());
            run(world, sleeping ? 3.0f : 0.02f);
            CHECK(world.awake_count() == (sleeping ? 0 : crowd.size() + 2 * lie.size() - 1));
            for (size_t i = 0; i < std::size(plates); ++i)
                blocks.push_back(block({static_cast<float>(2 * i), 0.3f, 0.0f}, true));
            const auto come = world.add_bodies(blocks);
            REQUIRE(come.has_value());
            run(world, 2.0f);
            for (size_t i = 0; i < std::size(plates); ++i) {
                CAPTURE(i);
                const auto& [length, large, fixed] = plates[i];
                const bool falls = !sleeping && !large && !fixed && length < longest;
                CHECK(std::abs(world.pose((*come)[i]).position.y - half - (falls ? 0.0f : 0.04f)) < 2e-3f);
                CHECK(std::abs(world.pose(lie[i]).position.y - half - 0.04f) < 2e-3f);
            }
            CHECK(world.awake_count() == 0);
        }
    }
}

TEST_CASE("debris: a body marked large carries debris of any size, unless it is debris itself") {
    World world;
    std::vector<BodyId> blocks;
    for (const bool large : {false, true})
        for (const bool debris : {false, true}) {
            const float x = static_cast<float>(blocks.size());
            BodyDesc plate = box({half, 0.02f, half}, 5.0f, {x, 0.02f, 0.0f});
            plate.large = large;
            plate.debris = debris;
            must_add(world, plate);
            blocks.push_back(must_add(world, block({x, 0.2f, 0.0f}, true)));
        }
    run(world, 2.0f);
    for (size_t i = 0; i < blocks.size(); ++i) {
        CAPTURE(i);
        CHECK(std::abs(world.pose(blocks[i]).position.y - half - (i == 2 ? 0.04f : 0.0f)) < 2e-3f);
    }
    CHECK(world.awake_count() == 0);
}

TEST_CASE("debris: on a removed body, it falls through a body of its own size to the ground") {
    World world;
    const BodyId table = must_add(world, box({0.3f, 0.05f, 0.3f}, 50.0f, {0.0f, 0.25f, 0.0f}));
    for (const float x : {-0.2f, 0.2f})
        must_add(world, box({0.02f, 0.1f, 0.3f}, 5.0f, {x, 0.1f, 0.0f})); // the legs of the table
    const BodyId like = must_add(world, block({0.0f, half, 0.0f}));
    const BodyId debris = must_add(world, block({0.02f, 0.3f + half + 0.01f, 0.01f}, true));
    run(world, 3.0f);
    CHECK(std::abs(world.pose(debris).position.y - 0.3f - half) < 2e-3f);
    CHECK(world.awake_count() == 0);
    REQUIRE(world.remove_body(table));
    CHECK(world.awake(debris));
    run(world, 3.0f);
    CHECK(std::abs(world.pose(debris).position.y - half) < 2e-3f);
    CHECK(std::abs(world.pose(like).position.y - half) < 2e-3f);
    CHECK(world.awake_count() == 0);
    CHECK(world.remove_body(like)); // which the debris overlaps
    CHECK(world.awake_count() == 0);
}

TEST_CASE("debris: among debris and larger bodies it comes to rest on what carries it, on any number of threads") {
    struct End {
        std::vector<uint64_t> hashes;
        float seconds = 0.0f;
    };
    const auto heap = [](uint32_t threads) {
        World world({.threads = threads});
        test::Random random(21);
        for (int i = 0; i < 240; ++i) {
            const glm::vec3 sides(
                random.point(glm::dvec3(i % 12 == 0 ? 0.1 : 0.02), glm::dvec3(i % 12 == 0 ? 0.2 : 0.06)));
            BodyDesc one = box(sides, 2000.0f * 8.0f * sides.x * sides.y * sides.z,
                               glm::vec3(random.point({-0.6, 0.1, -0.6}, {0.6, 2.0, 0.6})));
            one.debris = i % 12 != 0 && i % 2 == 1;
            must_add(world, one);
        }
        End end;
        for (; world.awake_count() > 0 && end.seconds < 10.0f; end.seconds += 0.25f) {
            run(world, 0.25f);
            end.hashes.push_back(world.state_hash());
        }
        CHECK(world.awake_count() == 0);
        for (const BodyId id : world.bodies()) CHECK(world.pose(id).position.y > 0.015f); // none in the ground
        return end;
    };
    const End alone = heap(1);
    CHECK(alone.seconds < 6.0f);
    for (const uint32_t threads : {2u, 3u}) CHECK(heap(threads).hashes == alone.hashes);
}

TEST_CASE("debris: a ball pushes all debris in its path, and momentum is conserved") {
    World world(empty_space);
    // Each overlaps another one, as debris may.
    std::vector<std::pair<BodyId, bool>> heap; // and whether it is in the ball's path
    for (int twice = 0; twice < 2; ++twice)
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z)
                    heap.emplace_back(
                        must_add(world, block(0.2f * glm::vec3(x, y, z) + 0.02f * static_cast<float>(twice), true)),
                        x == 0 && y == 0);
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
