// Debris by number: who it is, and what becomes of it.
#include "physics/crowd.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "bodies.h"
#include "convex_pieces.h"
#include "destruction_fixture.h"
#include "fracture/fracture.h"
#include "fracture/shapes.h"
#include "fracture/sites.h"
#include "physics/pieces.h"
#include "physics/structure.h"
#include "run_log.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;
using namespace brittle::physics::test_destruction;

namespace {

using Flags = std::vector<uint8_t>;

constexpr size_t no_limit = std::numeric_limits<size_t>::max();
constexpr float half = 0.05f; // m, of the boxes here: far above the size of small debris

// By looking at each body.
void check_counts(const World& world) {
    size_t awake = 0, colliding = 0;
    for (const BodyId id : world.bodies()) {
        awake += world.awake(id) && !world.fixed(id);
        colliding += world.awake(id) && !world.fixed(id) && !world.debris(id);
    }
    REQUIRE(world.awake_count() == awake);
    REQUIRE(world.colliding_count() == colliding);
}

size_t debris_count(const World& world) {
    return static_cast<size_t>(std::ranges::count_if(world.bodies(), [&](BodyId id) { return world.debris(id); }));
}

BodyDesc block(const glm::vec3& at, bool debris = false) {
    BodyDesc desc = box(glm::vec3(half), 1.0f, at);
    desc.debris = debris;
    return desc;
}

std::vector<BodyId> must_add_pieces(World& world, const fracture::Fragments& fragments) {
    Result<std::vector<BodyId>> bodies = add_pieces(world, fragments);
    REQUIRE(bodies.has_value());
    return *bodies;
}

// Indices by volume, the largest first, those that are equal as they come.
std::vector<size_t> by_volume(const fracture::Fragments& fragments) {
    std::vector<size_t> order(fragments.pieces.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::ranges::stable_sort(order, [&](size_t a, size_t b) {
        return fragments.pieces[a].mass.volume > fragments.pieces[b].mass.volume;
    });
    return order;
}

void strike_top(const World& world, Destruction& destruction, PieceId piece, double energy) {
    const glm::vec3 top = world.pose(destruction.body(piece)).position + glm::vec3(0.0f, destruction.solid(piece)->radius, 0.0f);
    REQUIRE(destruction.strike(world, piece, top, {0.0f, -1.0f, 0.0f}, energy));
}

} // namespace

TEST_CASE("crowd: nobody is debris of a batch that is empty, or has room") {
    for (const size_t room : {size_t{0}, size_t{1}, no_limit}) CHECK(crowded_out({}, room).empty());
    const std::vector<Newcomer> three{{.size = 1.0}, {.size = 3.0}, {.size = 2.0}};
    for (const size_t room : {size_t{3}, size_t{4}, no_limit}) CHECK(crowded_out(three, room) == Flags{0, 0, 0});
}

TEST_CASE("crowd: the smallest are debris, of equal ones the last, and never the largest") {
    const std::vector<Newcomer> three{{.size = 1.0}, {.size = 3.0}, {.size = 2.0}};
    CHECK(crowded_out(three, 2) == Flags{1, 0, 0});
    CHECK(crowded_out(three, 1) == Flags{1, 0, 1});
    CHECK(crowded_out(three, 0) == Flags{1, 0, 1});
    CHECK(crowded_out(three, 1, true) == Flags{1, 0, 1});
    CHECK(crowded_out(three, 0, true) == Flags{1, 1, 1});
    CHECK(crowded_out(three, 3, true) == Flags{0, 0, 0});
    const std::vector<Newcomer> equal(4, {.size = 0.5});
    CHECK(crowded_out(equal, 2) == Flags{0, 0, 1, 1});
    CHECK(crowded_out(equal, 0) == Flags{0, 1, 1, 1});
    for (const double size : {1.0, 0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
        CHECK(crowded_out(std::vector<Newcomer>{{.size = size}}, 0) == Flags{0});
}

TEST_CASE("crowd: sizes that are none are the smallest") {
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    const std::vector<Newcomer> batch{{.size = nan}, {.size = -infinity}, {.size = 1e-300},
                                      {.size = 0.0}, {.size = infinity},  {.size = nan}};
    CHECK(crowded_out(batch, 2) == Flags{1, 1, 0, 1, 0, 1});
    CHECK(crowded_out(batch, 3) == Flags{0, 1, 0, 1, 0, 1});
}

TEST_CASE("crowd: what is fixed takes no room, what is bonded takes it first") {
    CHECK(crowded_out(std::vector<Newcomer>(5, {.size = 1.0, .fixed = true}), 0) == Flags(5, 0));
    CHECK(crowded_out(std::vector<Newcomer>(5, {.size = 1.0, .bonded = true}), 0) == Flags(5, 0));
    // The largest is held: all else may be debris.
    const std::vector<Newcomer> held{{.size = 1.0}, {.size = 9.0, .fixed = true}, {.size = 2.0}, {.size = 1.0, .fixed = true}};
    CHECK(crowded_out(held, 0) == Flags{1, 0, 1, 0});
    CHECK(crowded_out(held, 1) == Flags{1, 0, 0, 0});
    CHECK(crowded_out(held, 2) == Flags{0, 0, 0, 0});
    // What is held is smaller than what comes off: that is what is left.
    const std::vector<Newcomer> crumb_held{{.size = 1.0, .fixed = true}, {.size = 9.0}, {.size = 2.0}};
    CHECK(crowded_out(crumb_held, 0) == Flags{0, 0, 1});
    const std::vector<Newcomer> bonded{{.size = 3.0}, {.size = 1.0, .bonded = true}, {.size = 4.0}, {.size = 2.0, .bonded = true}};
    CHECK(crowded_out(bonded, 2) == Flags{1, 0, 0, 0});
    CHECK(crowded_out(bonded, 3) == Flags{1, 0, 0, 0});
    CHECK(crowded_out(bonded, 0) == Flags{1, 0, 0, 0});
}

TEST_CASE("crowd: of a random batch exactly those collide that have fewer before them than there is room") {
    test::Random random(3);
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<Newcomer> batch(static_cast<size_t>(random.uniform(1.0, 40.0)));
        for (Newcomer& one : batch) one.size = std::floor(random.uniform(0.0, 10.0)); // many are equal
        const auto room = static_cast<size_t>(random.uniform(0.0, 45.0));
        const Flags debris = crowded_out(batch, room);
        for (size_t i = 0; i < batch.size(); ++i) {
            size_t before = 0;
            for (size_t k = 0; k < batch.size(); ++k)
                before += batch[k].size > batch[i].size || (batch[k].size == batch[i].size && k < i);
            CHECK(debris[i] == (before >= std::max(room, size_t{1}) ? 1 : 0));
        }
    }
}

TEST_CASE("crowd: room is what is left of the limit, and without a limit there is always some") {
    World world({.most_colliding = 3}), unlimited({.most_colliding = 0});
    for (World* one : {&world, &unlimited}) {
        BodyDesc fixed = block({0.0f, 0.0f, 9.0f});
        fixed.fixed = true;
        must_add(*one, fixed);
        must_add(*one, block({0.0f, 1.0f, 9.0f}, true));
    }
    CHECK(room_in(world) == 3);
    for (const size_t left : {2u, 1u, 0u, 0u}) { // who adds one by one is not asked
        must_add(world, block({static_cast<float>(left), 1.0f, 0.0f}));
        must_add(unlimited, block({static_cast<float>(left), 1.0f, 0.0f}));
        CHECK(room_in(world) == left);
        CHECK(room_in(unlimited) == no_limit);
    }
    CHECK(world.colliding_count() == 4);
    world.clear();
    CHECK(room_in(world) == 3);
    world.clear({.most_colliding = 7});
    CHECK(room_in(world) == 7);
}

TEST_CASE("crowd: the count of who collides is right after all that changes it") {
    for (const bool sleeping : {true, false}) {
        World world({.debris_size = 0.03f, .sleeping = sleeping});
        CHECK(world.colliding_count() == 0);
        test::Random random(11);
        const auto some = [&] {
            return world.bodies()[static_cast<size_t>(random.uniform(0.0, static_cast<double>(world.body_count())))];
        };
        size_t most = 0, least = no_limit;
        for (int i = 0; i < 1500; ++i) {
            const double what = random.uniform(0.0, 1.0);
            if (world.body_count() < 5 || (what < 0.25 && world.body_count() < 60 && i < 1000)) {
                const glm::vec3 at(random.point({-0.5, 0.1, -0.5}, {0.5, 0.6, 0.5}));
                BodyDesc desc = box(glm::vec3(what < 0.06 ? 0.01f : half), 1.0f, at);
                desc.fixed = what < 0.02;
                desc.debris = random.uniform(0.0, 1.0) < 0.3;
                const BodyId id = must_add(world, desc);
                CHECK(world.debris(id) == (!desc.fixed && (desc.debris || what < 0.06)));
            } else if (what < 0.3) {
                CHECK(world.remove_body(some()));
            } else if (what < 0.31) {
                world.apply_impulse(some(), {0.0f, 0.5f, 0.0f}, glm::vec3(0.0f));
            } else if (what < 0.32) {
                world.set_velocity(some(), {0.0f, 0.5f, 0.0f}, glm::vec3(0.0f));
            } else if (what < 0.325) {
                const BodyId id = some();
                world.move_on(id, world.rewind(id));
            } else if (what < 0.328) {
                world.wake_all();
            } else if (what < 0.3285) {
                world.clear();
            } else {
                for (int k = 0; k < (i < 1000 ? 3 : 10); ++k) world.step();
            }
            check_counts(world);
            most = std::max(most, world.colliding_count());
            if (i > 500) least = std::min(least, world.colliding_count());
        }
        CHECK(most > 10);
        if (sleeping) CHECK(least == 0);
    }
}

TEST_CASE("crowd: debris of any size falls through debris, but lies on the ground, on what is fixed and on what collides") {
    World world;
    for (const auto& [x, fixed] : {std::pair(2.0f, true), std::pair(4.0f, false)}) {
        BodyDesc floor = box({0.3f, 0.05f, 0.3f}, 50.0f, {x, 0.05f, 0.0f});
        floor.fixed = fixed;
        floor.debris = fixed; // not looked at
        must_add(world, floor);
    }
    std::vector<BodyId> blocks;
    for (const auto& [x, floor] : {std::pair(0.0f, 0.0f), std::pair(2.0f, 0.1f), std::pair(4.0f, 0.1f)})
        for (const float gap : {0.001f, 0.4f}) blocks.push_back(must_add(world, block({x, floor + half + gap, 0.0f}, true)));
    CHECK(world.colliding_count() == 1);
    run(world, 3.0f);
    for (size_t i = 0; i < blocks.size(); ++i) {
        CAPTURE(i);
        CHECK(world.debris(blocks[i]));
        CHECK(std::abs(world.pose(blocks[i]).position.y - (i < 2 ? half : 0.1f + half)) < 2e-3f);
    }
    CHECK(world.awake_count() == 0);
}

TEST_CASE("crowd: debris falls through what is not twice as long, and lies on what is, whoever came first") {
    // Plates that lie on the ground, the sides of the longest, and a block 10 cm long of debris above each.
    for (const bool debris_first : {false, true}) {
        World world;
        std::vector<BodyId> plates, blocks;
        const std::pair<float, bool> lengths[] = {{0.05f, false}, {0.1f, false}, {0.199f, false}, {0.201f, true}, {0.5f, true}};
        float x = 0.0f;
        for (const auto& [length, carries] : lengths) {
            BodyDesc plate = box({length / 2.0f, 0.02f, 0.45f * length}, 5.0f, {x, 0.02f, 0.0f});
            plate.pose.orientation = glm::angleAxis(x, glm::vec3(0.0f, 1.0f, 0.0f)); // however it lies
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

TEST_CASE("crowd: a body of several hulls is as long as all of them together") {
    World world;
    const glm::vec3 beam(0.15f, 0.02f, 0.05f);
    must_add(world, in_slabs(box(beam, 5.0f, {0.0f, 0.02f, 0.0f}), beam, 5)); // of slabs shorter than a block
    must_add(world, in_slabs(box(beam, 5.0f, {1.0f, 0.02f, 0.0f}), beam, 5));
    BodyDesc long_debris = in_slabs(box({0.16f, 0.02f, 0.02f}, 1.0f, {1.0f, 0.2f, 0.0f}), {0.16f, 0.02f, 0.02f}, 8);
    long_debris.debris = true;
    const BodyId lies = must_add(world, block({0.0f, 0.2f, 0.0f}, true)), falls = must_add(world, long_debris);
    run(world, 2.0f);
    CHECK(std::abs(world.pose(lies).position.y - 0.04f - half) < 2e-3f);
    CHECK(std::abs(world.pose(falls).position.y - 0.02f) < 2e-3f);
    CHECK(world.awake_count() == 0);
}

TEST_CASE("crowd: what moves drives debris if it is twice as long, and does not feel it otherwise, slow or fast") {
    for (const float speed : {0.5f, 5.0f, 50.0f}) {
        CAPTURE(speed);
        World world(empty_space);
        std::vector<std::pair<BodyId, BodyId>> rows; // who flies, at what
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
            const glm::vec3 flies = world.linear_velocity(rows[i].first), struck = world.linear_velocity(rows[i].second);
            if (i < 2) {
                CHECK(flies == glm::vec3(0.0f, 0.0f, -speed));
                CHECK(struck == glm::vec3(0.0f));
            } else { // 1 kg before 4 kg
                CHECK(-struck.z > 0.75f * speed);
                CHECK(-flies.z < 0.85f * speed);
            }
        }
        const Mechanics after = world.mechanics();
        CHECK(glm::length(after.momentum - before.momentum) < 1e-4 * glm::length(before.momentum));
        CHECK(after.kinetic <= before.kinetic);
    }
}

TEST_CASE("crowd: what debris meets grows with its number beyond twice the limit, and nowhere without one") {
    CHECK(crowding(0, 500) == 1.0f);
    CHECK(crowding(1000, 500) == 1.0f);
    CHECK(crowding(1001, 500) > 1.0f);
    CHECK(crowding(1500, 500) == 2.0f);
    CHECK(crowding(2000, 500) == 3.0f);
    CHECK(crowding(1, 1) == 1.0f);
    CHECK(crowding(4, 1) == 3.0f);
    CHECK(crowding(no_limit, 0) == 1.0f);
    CHECK(std::isfinite(crowding(no_limit, 1)));
    for (size_t debris = 1; debris < 3000; ++debris) CHECK(crowding(debris, 500) >= crowding(debris - 1, 500));
}

// Plates that lie on the ground, by their longest sides, a block of debris 10 cm long above each, and debris far away.
TEST_CASE("crowd: what comes into a crowd of debris falls through what carried the debris before it") {
    struct Plate {
        float length;
        bool large, fixed;
    };
    const Plate plates[] = {{0.25f, false, false}, {0.39f, false, false}, {0.41f, false, false},
                            {0.79f, false, false}, {0.81f, false, false}, {0.12f, true, false}, {0.3f, false, true}};
    // Debris far away, and the longest plate that a block falls through then: with the blocks that lie there and those that come it is 14
    // more.
    for (const auto& [others, longest] : {std::pair(0, 0.2f), std::pair(6, 0.2f), std::pair(16, 0.4f), std::pair(36, 0.8f)}) {
        for (const bool sleeping : {false, true}) { // the others, before the blocks come
            CAPTURE(others);
            CAPTURE(sleeping);
            World world({.most_colliding = 10});
            std::vector<BodyId> lie;
            for (size_t i = 0; i < std::size(plates); ++i) {
                const auto& [length, large, fixed] = plates[i];
                BodyDesc plate = box({length / 2.0f, 0.02f, length / 2.0f}, 20.0f, {static_cast<float>(2 * i), 0.02f, 0.0f});
                plate.large = large;
                plate.fixed = fixed;
                must_add(world, plate);
                lie.push_back(must_add(world, block({static_cast<float>(2 * i), 0.04f + half, 0.0f}, true))); // before there is a crowd
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

TEST_CASE("crowd: what is called large carries debris however small it is, unless it is debris itself") {
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

TEST_CASE("crowd: debris on a body that goes falls, and through its like on to the ground") {
    World world;
    const BodyId table = must_add(world, box({0.3f, 0.05f, 0.3f}, 50.0f, {0.0f, 0.25f, 0.0f}));
    for (const float x : {-0.2f, 0.2f}) must_add(world, box({0.02f, 0.1f, 0.3f}, 5.0f, {x, 0.1f, 0.0f})); // what it stands on
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
    CHECK(world.remove_body(like)); // in which it lies
    CHECK(world.awake_count() == 0);
}

TEST_CASE("crowd: debris among its like and what is larger comes to rest where something carries it, on any number of threads") {
    struct End {
        std::vector<uint64_t> hashes;
        float seconds = 0.0f;
    };
    const auto heap = [](uint32_t threads) {
        World world({.threads = threads});
        test::Random random(21);
        for (int i = 0; i < 240; ++i) {
            const glm::vec3 sides(random.point(glm::dvec3(i % 12 == 0 ? 0.1 : 0.02), glm::dvec3(i % 12 == 0 ? 0.2 : 0.06)));
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

TEST_CASE("crowd: a ball that is shot at debris drives all of it that is in its way, and momentum is kept") {
    World world(empty_space);
    // Each stands in another one, as debris may.
    std::vector<std::pair<BodyId, bool>> heap; // and whether it is in the way
    for (int twice = 0; twice < 2; ++twice)
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z)
                    heap.emplace_back(must_add(world, block(0.2f * glm::vec3(x, y, z) + 0.02f * static_cast<float>(twice), true)),
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

TEST_CASE("crowd: of fifteen hundred pieces that come at once the five hundred largest collide") {
    const fracture::TriangleMesh cube = fracture::cube(2.0);
    const auto broken = fracture::fracture(cube, fracture::uniform_sites(fracture::bounds(cube), 1500, 4));
    REQUIRE(broken.has_value());
    const fracture::Fragments& fragments = *broken;
    REQUIRE(fragments.pieces.size() == 1500);
    World world;
    const std::vector<BodyId> bodies = must_add_pieces(world, fragments);
    CHECK(world.colliding_count() == 500);
    const std::vector<size_t> order = by_volume(fragments);
    for (size_t i = 0; i < order.size(); ++i) CHECK(world.debris(bodies[order[i]]) == (i >= 500));
    // All of the next are debris but the largest.
    const std::vector<BodyId> more = must_add_pieces(world, fragments);
    CHECK(world.colliding_count() == 501);
    CHECK_FALSE(world.debris(more[order[0]]));
    // Without a limit all collide.
    World unlimited({.most_colliding = 0});
    must_add_pieces(unlimited, fragments);
    CHECK(unlimited.colliding_count() == 1500);
    CHECK(debris_count(unlimited) == 0);
}

TEST_CASE("crowd: what sleeps gives room, and what was debris stays it") {
    World world({.most_colliding = 6});
    const fracture::Fragments row = test::grid_pieces({0.0, 0.0, 0.0}, {0.8, 0.1, 0.1}, 8, 1, 1);
    const std::vector<BodyId> first = must_add_pieces(world, row);
    CHECK(world.colliding_count() == 6);
    CHECK(debris_count(world) == 2);
    run(world, 5.0f);
    REQUIRE(world.awake_count() == 0);
    CHECK(world.colliding_count() == 0);
    CHECK(room_in(world) == 6);
    Result<std::vector<BodyId>> second = add_pieces(world, row, {}, {.placement = {{0.0f, 0.0f, 3.0f}, {1.0f, 0.0f, 0.0f, 0.0f}}});
    REQUIRE(second.has_value());
    for (const std::vector<BodyId>& bodies : {first, *second})
        for (size_t i = 0; i < 8; ++i) CHECK(world.debris(bodies[i]) == (i >= 6));
    world.wake_all(); // more than enough may come to be awake
    CHECK(world.colliding_count() == 12);
    CHECK(room_in(world) == 0);
}

TEST_CASE("crowd: pieces that are refused leave the count as it was") {
    World world;
    fracture::Fragments bad = test::grid_pieces(glm::dvec3(0.0), glm::dvec3(1.0), 2, 2, 2);
    bad.pieces[5].mass.centre_of_mass.x = 1e300; // no place for a body in single precision
    CHECK_FALSE(add_pieces(world, bad).has_value());
    CHECK(world.body_count() == 0);
    CHECK(world.colliding_count() == 0);
}

TEST_CASE("crowd: of what a blow cuts off the smallest are debris, not what is left of it") {
    const auto broken = [](uint32_t most, int others) {
        WorldSettings settings = empty_space;
        settings.most_colliding = most;
        World world(settings);
        for (int i = 0; i < others; ++i) must_add(world, block({3.0f + static_cast<float>(i), 0.0f, 0.0f}));
        Destruction destruction;
        must_add(destruction, world, fracture::cube(1.0), desc_of(0.05));
        CHECK(debris_count(world) == 0);
        strike_top(world, destruction, destruction.pieces()[0], 500.0);
        run(world, destruction, 3);
        REQUIRE(destruction.pieces().size() > 15);
        std::vector<std::pair<double, bool>> made; // volume, debris
        for (const PieceId piece : destruction.pieces())
            made.emplace_back(destruction.solid(piece)->mass.volume, world.debris(destruction.body(piece)));
        std::ranges::sort(made, std::ranges::greater());
        size_t collide = 0;
        while (collide < made.size() && !made[collide].second) ++collide;
        for (size_t i = collide; i < made.size(); ++i) CHECK(made[i].second); // all that are smaller
        CHECK(world.colliding_count() == collide + static_cast<size_t>(others));
        return std::pair(collide, made.size());
    };
    CHECK(broken(10, 4).first == 6);
    CHECK(broken(10, 10).first == 1);
    CHECK(broken(10, 20).first == 1);
    const auto [all, made] = broken(0, 20);
    CHECK(all == made);
}

TEST_CASE("crowd: however often things break, no more collide than the limit has or did before") {
    WorldSettings settings = empty_space;
    settings.most_colliding = 12;
    for (const int others : {0, 20}) {
        World world(settings);
        for (int i = 0; i < others; ++i) must_add(world, block({3.0f + static_cast<float>(i), 0.0f, 0.0f}));
        Destruction destruction;
        must_add(destruction, world, fracture::cube(1.0), desc_of(0.05));
        RunLog log("a cube beside " + std::to_string(others) + " blocks");
        INFO(log);
        const size_t most = std::max<size_t>(12, world.colliding_count());
        size_t broken_debris = 0;
        test::Random random(7);
        for (int blow = 0; blow < 12; ++blow) {
            const std::vector<PieceId> pieces = destruction.pieces();
            const PieceId piece = pieces[static_cast<size_t>(random.uniform(0.0, static_cast<double>(pieces.size())))];
            const bool was_debris = world.debris(destruction.body(piece));
            const glm::vec3 at = world.pose(destruction.body(piece)).position;
            log.did("piece ", piece.value, " is struck from above at ", at, " with 300 J");
            if (!destruction.strike(world, piece, at, {0.0f, -1.0f, 0.0f}, 300.0)) continue;
            run(world, destruction, 3, &log);
            broken_debris += was_debris && !destruction.contains(piece);
            CHECK(world.colliding_count() <= most);
            check_counts(world);
        }
        CHECK(destruction.pieces().size() > 40);
        CHECK(broken_debris > 0);
    }
}

TEST_CASE("crowd: of a held thing the part that is held is what is left of it") {
    WorldSettings settings = empty_space;
    settings.most_colliding = 1;
    World world(settings);
    must_add(world, block({9.0f, 0.0f, 0.0f}));
    Destruction destruction;
    BreakableDesc desc = desc_of(0.05);
    desc.solid.anchors = {fracture::Box{{-1.0, -0.6, -1.0}, {1.0, -0.4, 1.0}}}; // the foot of the cube
    must_add(destruction, world, fracture::cube(1.0), desc);
    strike_top(world, destruction, destruction.pieces()[0], 300.0);
    run(world, destruction, 3);
    size_t fixed = 0;
    for (const PieceId piece : destruction.pieces()) {
        const BodyId body = destruction.body(piece);
        fixed += world.fixed(body);
        CHECK(world.debris(body) == !world.fixed(body));
    }
    CHECK(fixed > 0);
    CHECK(destruction.pieces().size() > fixed + 5);
    CHECK(world.fixed(destruction.body(largest(destruction))));
    CHECK(world.colliding_count() == 1);
}

TEST_CASE("crowd: single pieces that come off a structure are debris, several that are bonded never are") {
    WorldSettings settings = empty_space;
    settings.most_colliding = 3;
    World world(settings);
    const fracture::Fragments bar = test::bonded_grid({0.0, 0.0, 0.0}, {1.2, 0.1, 0.1}, 12, 1, 1);
    Result<Structure> made = Structure::create(world, bar);
    REQUIRE(made.has_value());
    Structure& structure = *made;
    const auto cut = [&](std::vector<uint32_t> bonds) { // between i and i + 1
        structure.break_bonds(bonds);
        structure.update(world);
    };
    const auto debris = [&](uint32_t piece) { return world.debris(structure.body_of(piece)); };
    CHECK(world.colliding_count() == 1);
    cut({3, 4, 5}); // 0-3, 4, 5, 6-11
    CHECK(world.colliding_count() == 3);
    CHECK(debris(4) != debris(5)); // there was room for one, and they are of the same size, up to rounding
    cut({8}); // 6-8, 9-11: both bonded
    CHECK(world.colliding_count() == 4);
    cut({0}); // 0, 1-3
    CHECK(debris(0));
    CHECK_FALSE(debris(1));
    CHECK(world.colliding_count() == 4);
    cut({6, 7}); // 6, 7, 8: nothing is left but single ones, one of which stays for them
    CHECK(debris(6) + debris(7) + debris(8) == 2);
    CHECK(world.colliding_count() == 4);
    CHECK(greatest_speed(world) == 0.0f);
}

TEST_CASE("crowd: a piece that its anchor lets go of is no debris, and what is held takes no room") {
    WorldSettings settings = empty_space;
    settings.most_colliding = 1;
    World world(settings);
    must_add(world, block({9.0f, 0.0f, 0.0f}));
    const fracture::Fragments bar = test::bonded_grid({0.0, 0.0, 0.0}, {0.4, 0.1, 0.1}, 4, 1, 1);
    Result<Structure> structure = Structure::create(world, bar, {.anchored = {0}});
    REQUIRE(structure.has_value());
    structure->break_bonds(std::array{0u, 2u}); // 0 held, 1-2, 3
    structure->update(world);
    CHECK(world.fixed(structure->body_of(0)));
    CHECK_FALSE(world.debris(structure->body_of(0)));
    CHECK_FALSE(world.debris(structure->body_of(1)));
    CHECK(world.debris(structure->body_of(3)));
    structure->release_anchors(std::array{0u});
    structure->update(world);
    CHECK_FALSE(world.fixed(structure->body_of(0)));
    CHECK_FALSE(world.debris(structure->body_of(0)));
    CHECK(world.colliding_count() == 3);
}

TEST_CASE("crowd: a crowd that breaks repeats on any number of threads, and few pieces fall as without a limit") {
    const auto story = [](WorldSettings settings) {
        World world(settings);
        Destruction destruction;
        BreakableDesc desc = desc_of(0.2);
        desc.motion.placement.position = {0.0f, 0.7f, 0.0f};
        must_add(destruction, world, fracture::cube(1.0), desc);
        Result<Structure> bar = Structure::create(
            world, test::bonded_grid({0.0, 0.0, 0.0}, {1.2, 0.1, 0.1}, 12, 1, 1),
            {.motion = {.placement = {{-0.6f, 1.5f, 0.0f}, {1.0f, 0.0f, 0.0f, 0.0f}}}});
        REQUIRE(bar.has_value());
        strike_top(world, destruction, destruction.pieces()[0], 400.0);
        std::vector<uint64_t> hashes;
        for (int step = 0; step < 120; ++step) {
            if (step == 20) bar->break_bonds(std::array{1u, 2u, 5u});
            if (step == 40)
                REQUIRE(add_pieces(world, test::voronoi_pieces(glm::dvec3(-0.3), glm::dvec3(0.3), 25, 8), {},
                                   {.placement = {{0.1f, 2.5f, 0.1f}, {1.0f, 0.0f, 0.0f, 0.0f}}})
                            .has_value());
            world.step();
            destruction.update(world);
            bar->update(world);
            if (step % 20 == 19) hashes.push_back(world.state_hash());
        }
        hashes.push_back(debris_count(world));
        return hashes;
    };
    const std::vector<uint64_t> alone = story({.threads = 1, .most_colliding = 20});
    CHECK(alone.back() > 20);
    for (const uint32_t threads : {2u, 3u}) CHECK(story({.threads = threads, .most_colliding = 20}) == alone);
    const std::vector<uint64_t> all = story({.most_colliding = 0});
    CHECK(story({}) == all);
    CHECK(all.back() == 0);
}

TEST_CASE("crowd: a heap most of which is debris comes to rest on the ground, and a shelf holds what falls on it") {
    World world({.most_colliding = 30});
    BodyDesc shelf = box({0.6f, 0.03f, 0.6f}, 1.0f, {0.3f, 0.5f, 0.0f});
    shelf.fixed = true;
    must_add(world, shelf);
    const fracture::Fragments fragments = test::voronoi_pieces(glm::dvec3(-0.5), glm::dvec3(0.5), 150, 2);
    const PlacedMotion above_it{.placement = {{0.0f, 1.5f, 0.0f}, {1.0f, 0.0f, 0.0f, 0.0f}}};
    Result<std::vector<BodyId>> bodies = add_pieces(world, fragments, {}, above_it);
    REQUIRE(bodies.has_value());
    CHECK(debris_count(world) == 120);
    for (int step = 0; step < 1200 && world.awake_count() > 0; ++step) world.step();
    CHECK(world.awake_count() == 0);
    size_t above = 0;
    for (size_t i = 0; i < bodies->size(); ++i) {
        const glm::vec3 at = world.pose((*bodies)[i]).position;
        CAPTURE(i);
        CHECK(at.y > 0.0f);
        const glm::vec3 local = at - shelf.pose.position;
        CHECK_FALSE((std::abs(local.x) < 0.6f && std::abs(local.y) < 0.03f && std::abs(local.z) < 0.6f)); // in the shelf
        above += local.y > 0.0f;
    }
    CHECK(above > 30);
}
