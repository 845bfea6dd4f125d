// Retirement and fading of debris: single pieces, bonded pieces that came off, and held pieces, which stay.
#include "physics/cutting/destruction.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "tests/physics/bodies.h"
#include "tests/physics/destruction_fixture.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;
using namespace brittle::physics::test_destruction;

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

// Fragments of blocks of 0.1 m on the ground, numbered along z, then y, then x.
ObjectId must_add_blocks(Destruction& destruction, World& world, const glm::ivec3& count,
                         const StructureDesc& structure = {}, double min_size = 0.02) {
    fracture::TriangleMesh box = fracture::cuboid(0.1 * glm::dvec3(count));
    for (glm::dvec3& p : box.positions) p += 0.05 * glm::dvec3(count);
    std::vector<glm::dvec3> sites;
    for (int i = 0; i < count.x; ++i)
        for (int j = 0; j < count.y; ++j)
            for (int k = 0; k < count.z; ++k) sites.push_back(0.1 * glm::dvec3(i, j, k) + 0.05);
    const fracture::Result<fracture::Fragments> blocks = fracture::fracture(box, sites);
    REQUIRE(blocks.has_value());
    REQUIRE(blocks->pieces.size() == sites.size());
    const Result<ObjectId> object = destruction.add(world, *blocks, structure, desc_of(min_size));
    REQUIRE_MESSAGE(object.has_value(), (object ? std::string() : object.error().message));
    return *object;
}

// Cuts the bonds between each of these blocks of a bar along x and its next block.
void cut(Structure& bar, std::initializer_list<uint32_t> blocks) {
    for (uint32_t bond = 0; bond < bar.graph().bonds().size(); ++bond)
        if (std::ranges::find(blocks, bar.graph().bonds()[bond].a) != blocks.end()) bar.break_bonds(std::array{bond});
}

bool unseen(const glm::vec3&, float) {
    return false;
}

} // namespace

TEST_CASE("debris: excess is retired, invisible first, then small and old, and visible debris fades") {
    const DebrisLimits limits{.max_pieces = 4, .max_vertices = 1000, .sleep_seconds = 10.0};
    CHECK(retire_debris({}, 100, 100, limits).empty());
    std::vector<Debris> debris;
    for (uint32_t i = 0; i < 4; ++i)
        debris.push_back({.id = {i}, .volume = 1.0 + i, .age = 1.0, .vertices = 10, .visible = i != 3});
    CHECK(retire_debris(debris, 4, 40, limits).empty());
    CHECK(retire_debris(debris, 5, 40, limits) == std::vector{PieceId{3}});
    CHECK(retire_debris(debris, 6, 40, limits) == std::vector{PieceId{3}, PieceId{0}});
    debris[2].age = 100.0;
    CHECK(retire_debris(debris, 6, 40, limits) == std::vector{PieceId{3}, PieceId{2}});
    CHECK(retire_debris(debris, 4, 1015, limits) == std::vector{PieceId{3}, PieceId{2}});
    CHECK(retire_debris(debris, 100, 0, limits).size() == 4);
    debris[1].slept = 11.0;
    CHECK(retire_debris(debris, 4, 40, limits) == std::vector{PieceId{1}});
}

TEST_CASE("destruction: excess debris fades in view and is removed out of view, whole and held pieces stay") {
    for (const bool seen : {true, false}) {
        World world(empty_space);
        Destruction destruction({.debris = {.max_pieces = 10, .fade_seconds = 0.1}});
        destruction.set_view([=](const glm::vec3&, float) { return seen; });
        must_add(destruction, world, fracture::cube(1.0), desc_of(0.05));
        REQUIRE(strike_from_above(world, destruction, destruction.pieces()[0], 500.0));
        run(world, destruction, 2);
        const size_t made = destruction.pieces().size();
        CHECK(destruction.take_events().removed.size() == 0);
        if (seen) {
            REQUIRE(made > 15);
            float share = 1.0f;
            for (int step = 0; step < 11; ++step) {
                run(world, destruction, 1);
                const DestructionEvents events = destruction.take_events();
                CHECK(events.removed.empty());
                REQUIRE(events.fading.size() == made - 10);
                CHECK(events.fading[0].share < share);
                share = events.fading[0].share;
            }
            CHECK(share < 0.1f);
            run(world, destruction, 1);
            CHECK(destruction.take_events().removed.size() == made - 10);
        }
        CHECK(destruction.pieces().size() == 10);
        CHECK(world.body_count() == 10);
    }
}

TEST_CASE("destruction: visible debris stays as long as removing the invisible is enough") {
    const auto to_the_right = [](const glm::vec3& centre, float) { return centre.x > 0.0f; };
    const auto broken_cube = [&](World& world, size_t most) {
        auto destruction = std::make_unique<Destruction>(DestructionSettings{.debris = {.max_pieces = most}});
        destruction->set_view(to_the_right);
        must_add(*destruction, world, fracture::cube(1.0), desc_of(0.05));
        REQUIRE(strike_from_above(world, *destruction, destruction->pieces()[0], 500.0));
        run(world, *destruction, 2);
        return destruction;
    };
    World roomy(empty_space), narrow(empty_space);
    const auto all = broken_cube(roomy, 1000);
    size_t unseen = 0;
    for (const PieceId piece : all->pieces()) unseen += !to_the_right(roomy.pose(all->body(piece)).position, 0.0f);
    REQUIRE(unseen > 5);
    const size_t most = all->pieces().size() - unseen / 2;
    const auto some = broken_cube(narrow, most);
    CHECK(some->take_events().fading.empty());
    CHECK(some->pieces().size() == most);
    for (const PieceId piece : all->pieces())
        if (!some->contains(piece)) CHECK(roomy.pose(all->body(piece)).position.x <= 0.0f);
}

TEST_CASE("destruction: visibility is tested only where debris is to be retired") {
    World world(empty_space);
    Destruction destruction({.debris = {.max_pieces = 1000}});
    must_add(destruction, world, fracture::cube(1.0), desc_of(0.05));
    REQUIRE(strike_from_above(world, destruction, destruction.pieces()[0], 500.0));
    int asked = 0;
    destruction.set_view([&](const glm::vec3&, float) { return ++asked, true; });
    run(world, destruction, 10);
    CHECK(destruction.pieces().size() > 20);
    CHECK(asked == 0);
}

TEST_CASE("destruction: bonded debris stays within the limit, and none sleeps too long") {
    for (const double sleep_seconds : {never, 1.0}) {
        CAPTURE(sleep_seconds);
        World world;
        Destruction destruction({.debris = {.max_pieces = 20, .sleep_seconds = sleep_seconds}});
        const ObjectId wall = must_add_blocks(destruction, world, {10, 10, 2}, {}, 0.2); // too small to be cut
        REQUIRE(destruction.pieces().size() == 200);
        for (uint32_t piece = 0; piece < 200; ++piece) destruction.structure(wall)->isolate(piece);
        run(world, destruction, 2 * 120);
        CHECK(destruction.pieces().size() == 20); // all others have faded
        CHECK(world.body_count() == destruction.pieces().size());
        run(world, destruction, 13 * 120);
        CHECK(destruction.pieces().size() == (sleep_seconds == never ? 20 : 0));
        CHECK(destruction.statistics().retired == 200 - destruction.pieces().size());
        CHECK((destruction.structure(wall) == nullptr) == destruction.pieces().empty());
    }
}

TEST_CASE("destruction: anchored pieces stay beyond the limit, and the smallest that came off go first") {
    World world(empty_space);
    Destruction destruction({.debris = {.max_pieces = 1, .sleep_seconds = 0.0}});
    destruction.set_view(unseen);
    const ObjectId bar =
        must_add_blocks(destruction, world, {12, 1, 1}, {.anchored = {0, 7}, .wear = {.enabled = false}});
    const std::vector<PieceId> all = destruction.pieces();
    run(world, destruction, 10);
    CHECK(destruction.pieces() == all); // no piece has come off
    // 0 and 1 stay, and 7, which is alone and anchored. 2 is retired, and 3 to 6, and 8 to 11.
    cut(*destruction.structure(bar), {1, 2, 6, 7});
    run(world, destruction, 1);
    CHECK(destruction.pieces() == std::vector{all[0], all[1], all[7]});
    CHECK(world.body_count() == 2);
    CHECK(destruction.structure(bar)->graph().live_count() == 1);
    run(world, destruction, 10);
    CHECK(destruction.pieces().size() == 3);
    // A piece that came off while it was anchored becomes debris when its anchor is released.
    destruction.structure(bar)->release_anchors(std::vector<uint32_t>{7});
    run(world, destruction, 2);
    CHECK(destruction.pieces() == std::vector{all[0], all[1]});
}

TEST_CASE("destruction: the greater part of a free structure stays, and so does a piece that was always alone") {
    World world(empty_space);
    Destruction destruction({.debris = {.max_pieces = 1}});
    destruction.set_view(unseen);
    const ObjectId bar = must_add_blocks(destruction, world, {7, 1, 1});
    const ObjectId block =
        must_add_blocks(destruction, world, {1, 1, 1}, {.motion = {.placement = {{0.0f, 5.0f, 0.0f}}}});
    const std::vector<PieceId> all = destruction.pieces();
    REQUIRE(all.size() == 8);
    cut(*destruction.structure(bar), {2});
    run(world, destruction, 2);
    CHECK(destruction.pieces() == std::vector{all[3], all[4], all[5], all[6], all[7]});
    cut(*destruction.structure(bar), {4}); // now neither half has more than half of the seven
    run(world, destruction, 2);
    CHECK(destruction.pieces() == std::vector{all[7]});
    CHECK(destruction.structure(bar) == nullptr);
    CHECK(destruction.structure(block) != nullptr);
}

TEST_CASE("destruction: no more groups are retired than the limit requires, small and old ones first") {
    for (const int more : {0, 1, 3, 4, 5, 6, 9}) {
        CAPTURE(more);
        World world(empty_space);
        Destruction destruction({.debris = {.max_pieces = 12, .sleep_seconds = never}});
        destruction.set_view(unseen);
        const ObjectId bar =
            must_add_blocks(destruction, world, {12, 1, 1}, {.anchored = {0}, .wear = {.enabled = false}});
        const std::vector<PieceId> all = destruction.pieces();
        run(world, destruction, 1200);
        cut(*destruction.structure(bar), {8});
        run(world, destruction, 120);
        cut(*destruction.structure(bar), {5, 6});
        run(world, destruction, 1);
        CHECK(destruction.pieces() == all);
        if (more > 0)
            must_add_blocks(destruction, world, {more, 1, 1},
                            {.motion = {.placement = {{0.0f, 5.0f, 0.0f}}}, .anchored = {0}});
        run(world, destruction, 1);
        for (const uint32_t first : {9u, 10u, 11u}) CHECK(destruction.contains(all[first]) == (more < 1));
        CHECK(destruction.contains(all[6]) == (more < 4));
        for (const uint32_t second : {7u, 8u}) CHECK(destruction.contains(all[second]) == (more < 5));
        for (uint32_t held = 0; held < 6; ++held) CHECK(destruction.contains(all[held]));
    }
}

TEST_CASE("destruction: visible bonded pieces fade together, and their slots are reused") {
    World world(empty_space);
    Destruction destruction({.debris = {.max_pieces = 1, .fade_seconds = 0.1}});
    glm::vec3 eye(0.55f, 0.05f, 0.05f); // inside the last block but one
    destruction.set_view([&](const glm::vec3& centre, float radius) { return glm::distance(eye, centre) <= radius; });
    const ObjectId bar = must_add_blocks(destruction, world, {7, 1, 1}, {.anchored = {0}, .wear = {.enabled = false}});
    const std::vector<PieceId> all = destruction.pieces();
    (void)destruction.take_events();
    cut(*destruction.structure(bar), {2, 4});
    run(world, destruction, 1);
    // The group of 3 and 4 is invisible; of 5 and 6, one is visible.
    DestructionEvents events = destruction.take_events();
    REQUIRE(events.removed.size() == 2);
    CHECK(events.removed[0].id == all[3]);
    CHECK(events.removed[1].id == all[4]);
    float share = 1.0f;
    for (int step = 0; step < 11; ++step) {
        if (step == 5) cut(*destruction.structure(bar), {5}); // separated pieces keep fading
        run(world, destruction, 1);
        events = destruction.take_events();
        CHECK(events.removed.empty());
        REQUIRE(events.fading.size() == 2);
        CHECK(events.fading[0].id == all[5]);
        CHECK(events.fading[1].id == all[6]);
        CHECK(events.fading[0].share == events.fading[1].share);
        CHECK(events.fading[0].share < share);
        share = events.fading[0].share;
        CHECK_FALSE(destruction.strike(world, all[5], {0.5f, 0.05f, 0.05f}, {1.0f, 0.0f, 0.0f}, 1e3));
    }
    CHECK(world.body_count() == 3);
    run(world, destruction, 1);
    events = destruction.take_events();
    REQUIRE(events.removed.size() == 2);
    CHECK(events.removed[0].slot == 5);
    CHECK(events.removed[1].slot == 6);
    CHECK(world.body_count() == 1);
    CHECK(destruction.statistics().retired == 4);
    must_add_blocks(destruction, world, {4, 1, 1}, {.motion = {.placement = {{0.0f, 5.0f, 0.0f}}}});
    events = destruction.take_events();
    REQUIRE(events.added.size() == 4);
    for (uint32_t k = 0; k < 4; ++k) CHECK(events.added[k].slot == 3 + k);
    CHECK(destruction.slot_count() == 7);
}

TEST_CASE("destruction: a faded piece is retired once, although its step has an excess again") {
    for (const bool bonded : {false, true}) {
        CAPTURE(bonded);
        World world(empty_space);
        Destruction destruction(
            {.latency = 1, .debris = {.max_pieces = 1, .sleep_seconds = never, .fade_seconds = 0.1}});
        bool seen = true;
        destruction.set_view([&](const glm::vec3&, float) { return seen; });
        const auto break_one = [&](float height) {
            const PieceId first = destruction.next_piece();
            const PlacedMotion motion{.placement = {{0.0f, height, 0.0f}}};
            if (bonded) {
                cut(*destruction.structure(must_add_blocks(destruction, world, {2, 1, 1}, {.motion = motion})), {0});
            } else {
                BreakableDesc desc = desc_of(0.05);
                desc.motion = motion;
                must_add(destruction, world, fracture::cube(1.0), desc);
                REQUIRE(destruction.strike(world, first, {0.0f, height + 0.5f, 0.0f}, {0.0f, -1.0f, 0.0f}, 500.0));
            }
        };
        break_one(0.0f);
        run(world, destruction, 12);
        CHECK(destruction.pieces().size() > 1);
        break_one(5.0f);
        seen = false;
        run(world, destruction, 1); // the step in which the first has faded
        CHECK(destruction.pieces().size() == 1);
        CHECK(world.body_count() == 1);
        CHECK(destruction.statistics().retired + 1 == destruction.next_piece().value - (bonded ? 0u : 2u));
    }
}

TEST_CASE("destruction: a piece with a job, and pieces bonded to it, stay until the commit") {
    World world(empty_space);
    Destruction destruction({.latency = 6, .debris = {.max_pieces = 3, .sleep_seconds = never}});
    destruction.set_view(unseen);
    const ObjectId bar = must_add_blocks(destruction, world, {8, 1, 1}, {.anchored = {0}, .wear = {.enabled = false}});
    const std::vector<PieceId> all = destruction.pieces();
    cut(*destruction.structure(bar), {3, 6});
    // 7 comes off alone, 4 to 6 together; both are struck before the next update.
    const auto strike = [&](uint32_t block) {
        const float x = 0.1f * static_cast<float>(block) + 0.05f;
        return destruction.strike(world, all[block], {x, 0.1f, 0.05f}, {0.0f, -1.0f, 0.0f}, 5.0);
    };
    REQUIRE(strike(7));
    REQUIRE(strike(5));
    CHECK(destruction.jobs_in_flight() == 2);
    run(world, destruction, 1);
    CHECK(destruction.pieces() == all);
    CHECK(destruction.jobs_in_flight() == 2);
    run(world, destruction, 10);
    CHECK(destruction.jobs_in_flight() == 0);
    CHECK(destruction.statistics().commits == 2);
    CHECK(destruction.next_piece().value > 10); // they were cut, and what came of 4 to 7 was retired
    CHECK(destruction.pieces() == std::vector{all[0], all[1], all[2], all[3]});
    CHECK(world.body_count() == 1);
}

TEST_CASE("destruction: removing a bonded object while pieces fade leaves nothing") {
    World world(empty_space);
    Destruction destruction({.debris = {.max_pieces = 1}});
    const ObjectId bar = must_add_blocks(destruction, world, {8, 1, 1}, {.anchored = {0}});
    for (uint32_t piece = 0; piece < 8; ++piece) destruction.structure(bar)->isolate(piece);
    run(world, destruction, 5);
    CHECK(destruction.take_events().fading.size() == 7);
    destruction.remove(world, bar);
    CHECK(world.body_count() == 0);
    CHECK(destruction.pieces().empty());
    run(world, destruction, 200);
    CHECK(destruction.take_events().removed.size() == 8);
}

TEST_CASE("destruction: retired debris does not change the motion of the others") {
    const PlacedMotion spin{.linear_velocity = {1.0f, 0.5f, 0.0f}, .angular_velocity = {1.0f, 3.0f, 1.0f}};
    std::optional<World> roomy, narrow;
    std::vector<PieceId> left;
    BodyId body; // the body of 3 to 7
    for (const size_t most : {100u, 5u}) {
        World& world = (most == 100 ? roomy : narrow).emplace(empty_space);
        Destruction destruction({.debris = {.max_pieces = most, .sleep_seconds = never, .fade_seconds = 0.1}});
        const ObjectId bar = must_add_blocks(destruction, world, {9, 1, 1}, {.motion = spin});
        run(world, destruction, 20);
        cut(*destruction.structure(bar), {0, 2, 7});
        const Mechanics before = world.mechanics();
        run(world, destruction, 1);
        CHECK(glm::length(world.mechanics().momentum - before.momentum) < 1e-5 * glm::length(before.momentum));
        run(world, destruction, 60);
        left = destruction.pieces();
        body = destruction.body({3});
    }
    REQUIRE(left == std::vector<PieceId>{{3}, {4}, {5}, {6}, {7}});
    REQUIRE(narrow->body_count() == 1);
    for (const World* world : {&*roomy, &*narrow}) REQUIRE(world->contains(body));
    CHECK(narrow->linear_velocity(body) == roomy->linear_velocity(body));
    CHECK(narrow->angular_velocity(body) == roomy->angular_velocity(body));
    CHECK(narrow->pose(body).position == roomy->pose(body).position);
}

TEST_CASE("destruction: runs that retire bonded debris are equal bit for bit with any number of threads"
          * doctest::test_suite("long")) {
    const auto fall = [](uint32_t threads, uint32_t workers) {
        WorldSettings settings;
        settings.threads = threads;
        World world(settings);
        Destruction destruction(
            {.workers = workers, .debris = {.max_pieces = 60, .sleep_seconds = 0.2, .fade_seconds = 0.2}});
        destruction.set_view([](const glm::vec3& centre, float) { return centre.x > 0.4f; });
        must_add_blocks(destruction, world, {8, 8, 2}, {.material = weak, .anchored = {0, 1, 16, 17, 32, 33}});
        std::vector<uint64_t> states;
        for (int step = 0; step < 300; ++step) {
            if (step % 60 == 5)
                shoot(world, 0.1f, 20.0f, {0.2f + 0.001f * static_cast<float>(step), 0.4f, 2.0f}, {0.0f, 0.0f, -20.0f});
            run(world, destruction, 1);
            states.push_back(world.state_hash());
            for (const PieceId piece : destruction.pieces()) states.push_back(piece.value);
        }
        CHECK(destruction.statistics().retired > 60);
        MESSAGE(destruction.pieces().size(), " pieces left, ", destruction.statistics().retired, " gone");
        return states;
    };
    const std::vector<uint64_t> once = fall(1, 1);
    CHECK(fall(2, 1) == once);
    CHECK(fall(4, 4) == once);
}
