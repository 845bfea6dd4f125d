// Debris because of too many colliding bodies: the choice, and its effects.
#include "physics/world/crowd.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "physics/bonds/structure.h"
#include "physics/world/pieces.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"
#include "tests/physics/destruction_fixture.h"
#include "tests/physics/run_log.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;
using namespace brittle::physics::test_destruction;

namespace {

using Flags = std::vector<uint8_t>;

constexpr size_t no_limit = std::numeric_limits<size_t>::max();
constexpr float half = block_half;

// Compares the world's counts with a count over all bodies.
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

std::vector<BodyId> must_add_pieces(World& world, const fracture::Fragments& fragments) {
    Result<std::vector<BodyId>> bodies = add_pieces(world, fragments);
    REQUIRE(bodies.has_value());
    return *bodies;
}

// Returns indices by descending volume; equal volumes keep their order.
std::vector<size_t> by_volume(const fracture::Fragments& fragments) {
    std::vector<size_t> order(fragments.pieces.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::ranges::stable_sort(
        order, [&](size_t a, size_t b) { return fragments.pieces[a].mass.volume > fragments.pieces[b].mass.volume; });
    return order;
}

void strike_top(const World& world, Destruction& destruction, PieceId piece, double energy) {
    const glm::vec3 top =
        world.pose(destruction.body(piece)).position + glm::vec3(0.0f, destruction.solid(piece)->radius, 0.0f);
    REQUIRE(destruction.strike(world, piece, top, {0.0f, -1.0f, 0.0f}, energy));
}

} // namespace

TEST_CASE("crowd: a batch that is empty or has room contains no debris") {
    for (const size_t room : {size_t{0}, size_t{1}, no_limit}) CHECK(choose_debris({}, room).empty());
    const std::vector<BatchBody> three{{.size = 1.0}, {.size = 3.0}, {.size = 2.0}};
    for (const size_t room : {size_t{3}, size_t{4}, no_limit}) CHECK(choose_debris(three, room) == Flags{0, 0, 0});
}

TEST_CASE("crowd: the smallest bodies are debris, the last among equals, and never the largest") {
    const std::vector<BatchBody> three{{.size = 1.0}, {.size = 3.0}, {.size = 2.0}};
    CHECK(choose_debris(three, 2) == Flags{1, 0, 0});
    CHECK(choose_debris(three, 1) == Flags{1, 0, 1});
    CHECK(choose_debris(three, 0) == Flags{1, 0, 1});
    CHECK(choose_debris(three, 1, true) == Flags{1, 0, 1});
    CHECK(choose_debris(three, 0, true) == Flags{1, 1, 1});
    CHECK(choose_debris(three, 3, true) == Flags{0, 0, 0});
    const std::vector<BatchBody> equal(4, {.size = 0.5});
    CHECK(choose_debris(equal, 2) == Flags{0, 0, 1, 1});
    CHECK(choose_debris(equal, 0) == Flags{0, 1, 1, 1});
    for (const double size : {1.0, 0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
        CHECK(choose_debris(std::vector<BatchBody>{{.size = size}}, 0) == Flags{0});
}

TEST_CASE("crowd: NaN and negative sizes count as the smallest") {
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    const std::vector<BatchBody> batch{{.size = nan}, {.size = -infinity}, {.size = 1e-300},
                                       {.size = 0.0}, {.size = infinity},  {.size = nan}};
    CHECK(choose_debris(batch, 2) == Flags{1, 1, 0, 1, 0, 1});
    CHECK(choose_debris(batch, 3) == Flags{0, 1, 0, 1, 0, 1});
}

TEST_CASE("crowd: fixed bodies take no room, and bonded ones take it first") {
    CHECK(choose_debris(std::vector<BatchBody>(5, {.size = 1.0, .fixed = true}), 0) == Flags(5, 0));
    CHECK(choose_debris(std::vector<BatchBody>(5, {.size = 1.0, .bonded = true}), 0) == Flags(5, 0));
    // The largest is fixed: all others may be debris.
    const std::vector<BatchBody> held{
        {.size = 1.0}, {.size = 9.0, .fixed = true}, {.size = 2.0}, {.size = 1.0, .fixed = true}};
    CHECK(choose_debris(held, 0) == Flags{1, 0, 1, 0});
    CHECK(choose_debris(held, 1) == Flags{1, 0, 0, 0});
    CHECK(choose_debris(held, 2) == Flags{0, 0, 0, 0});
    // The fixed body is smaller than a free one, which collides as the largest.
    const std::vector<BatchBody> crumb_held{{.size = 1.0, .fixed = true}, {.size = 9.0}, {.size = 2.0}};
    CHECK(choose_debris(crumb_held, 0) == Flags{0, 0, 1});
    const std::vector<BatchBody> bonded{
        {.size = 3.0}, {.size = 1.0, .bonded = true}, {.size = 4.0}, {.size = 2.0, .bonded = true}};
    CHECK(choose_debris(bonded, 2) == Flags{1, 0, 0, 0});
    CHECK(choose_debris(bonded, 3) == Flags{1, 0, 0, 0});
    CHECK(choose_debris(bonded, 0) == Flags{1, 0, 0, 0});
}

TEST_CASE("crowd: in a random batch the largest bodies collide, as many as there is room for") {
    test::Random random(3);
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<BatchBody> batch(static_cast<size_t>(random.uniform(1.0, 40.0)));
        for (BatchBody& one : batch) one.size = std::floor(random.uniform(0.0, 10.0)); // many equal sizes
        const auto room = static_cast<size_t>(random.uniform(0.0, 45.0));
        const Flags debris = choose_debris(batch, room);
        for (size_t i = 0; i < batch.size(); ++i) {
            size_t before = 0;
            for (size_t k = 0; k < batch.size(); ++k)
                before += batch[k].size > batch[i].size || (batch[k].size == batch[i].size && k < i);
            CHECK(debris[i] == (before >= std::max(room, size_t{1}) ? 1 : 0));
        }
    }
}

TEST_CASE("crowd: room is the rest of the limit, and unbounded without a limit") {
    World world({.max_colliding = 3}), unlimited({.max_colliding = 0});
    for (World* one : {&world, &unlimited}) {
        BodyDesc fixed = block({0.0f, 0.0f, 9.0f});
        fixed.fixed = true;
        must_add(*one, fixed);
        must_add(*one, block({0.0f, 1.0f, 9.0f}, true));
    }
    CHECK(colliding_room(world) == 3);
    for (const size_t left : {2u, 1u, 0u, 0u}) { // add_body() ignores the limit
        must_add(world, block({static_cast<float>(left), 1.0f, 0.0f}));
        must_add(unlimited, block({static_cast<float>(left), 1.0f, 0.0f}));
        CHECK(colliding_room(world) == left);
        CHECK(colliding_room(unlimited) == no_limit);
    }
    CHECK(world.colliding_count() == 4);
    world.clear();
    CHECK(colliding_room(world) == 3);
    world.clear({.max_colliding = 7});
    CHECK(colliding_room(world) == 7);
}

TEST_CASE("crowd: the count of colliding bodies is right after every operation that changes it") {
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

TEST_CASE("crowd: of fifteen hundred pieces that are added at once the five hundred largest collide") {
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
    // Of the next batch all but the largest are debris.
    const std::vector<BodyId> more = must_add_pieces(world, fragments);
    CHECK(world.colliding_count() == 501);
    CHECK_FALSE(world.debris(more[order[0]]));
    // Without a limit all collide.
    World unlimited({.max_colliding = 0});
    must_add_pieces(unlimited, fragments);
    CHECK(unlimited.colliding_count() == 1500);
    CHECK(debris_count(unlimited) == 0);
}

TEST_CASE("crowd: sleeping bodies free room, and debris remains debris") {
    World world({.max_colliding = 6});
    const fracture::Fragments row = test::grid_pieces({0.0, 0.0, 0.0}, {0.8, 0.1, 0.1}, 8, 1, 1);
    const std::vector<BodyId> first = must_add_pieces(world, row);
    CHECK(world.colliding_count() == 6);
    CHECK(debris_count(world) == 2);
    run(world, 5.0f);
    REQUIRE(world.awake_count() == 0);
    CHECK(world.colliding_count() == 0);
    CHECK(colliding_room(world) == 6);
    Result<std::vector<BodyId>> second =
        add_pieces(world, row, {}, {.placement = {{0.0f, 0.0f, 3.0f}, {1.0f, 0.0f, 0.0f, 0.0f}}});
    REQUIRE(second.has_value());
    for (const std::vector<BodyId>& bodies : {first, *second})
        for (size_t i = 0; i < 8; ++i) CHECK(world.debris(bodies[i]) == (i >= 6));
    world.wake_all(); // waking may exceed the limit
    CHECK(world.colliding_count() == 12);
    CHECK(colliding_room(world) == 0);
}

TEST_CASE("crowd: refused pieces leave the count unchanged") {
    World world;
    fracture::Fragments bad = test::grid_pieces(glm::dvec3(0.0), glm::dvec3(1.0), 2, 2, 2);
    bad.pieces[5].mass.centre_of_mass.x = 1e300; // beyond single precision
    CHECK_FALSE(add_pieces(world, bad).has_value());
    CHECK(world.body_count() == 0);
    CHECK(world.colliding_count() == 0);
}

TEST_CASE("crowd: the smallest parts of a struck piece are debris, and the largest part never") {
    const auto broken = [](uint32_t most, int others) {
        WorldSettings settings = empty_space;
        settings.max_colliding = most;
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
        for (size_t i = collide; i < made.size(); ++i) CHECK(made[i].second); // all smaller parts
        CHECK(world.colliding_count() == collide + static_cast<size_t>(others));
        return std::pair(collide, made.size());
    };
    CHECK(broken(10, 4).first == 6);
    CHECK(broken(10, 10).first == 1);
    CHECK(broken(10, 20).first == 1);
    const auto [all, made] = broken(0, 20);
    CHECK(all == made);
}

TEST_CASE("crowd: repeated breaks never raise the number of colliding bodies above the limit or its start") {
    WorldSettings settings = empty_space;
    settings.max_colliding = 12;
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

TEST_CASE("crowd: when a held object breaks, the held part is the one that is no debris") {
    WorldSettings settings = empty_space;
    settings.max_colliding = 1;
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

TEST_CASE("crowd: single pieces that come off a structure are debris, and bonded groups never") {
    WorldSettings settings = empty_space;
    settings.max_colliding = 3;
    World world(settings);
    const fracture::Fragments bar = test::bonded_grid({0.0, 0.0, 0.0}, {1.2, 0.1, 0.1}, 12, 1, 1);
    Result<Structure> made = Structure::create(world, bar);
    REQUIRE(made.has_value());
    Structure& structure = *made;
    const auto cut = [&](std::vector<uint32_t> bonds) { // bond i lies between pieces i and i + 1
        structure.break_bonds(bonds);
        structure.update(world);
    };
    const auto debris = [&](uint32_t piece) { return world.debris(structure.body_of(piece)); };
    CHECK(world.colliding_count() == 1);
    cut({3, 4, 5}); // 0-3, 4, 5, 6-11
    CHECK(world.colliding_count() == 3);
    CHECK(debris(4) != debris(5)); // room for one; their sizes are equal up to rounding
    cut({8});                      // 6-8, 9-11: both bonded
    CHECK(world.colliding_count() == 4);
    cut({0}); // 0, 1-3
    CHECK(debris(0));
    CHECK_FALSE(debris(1));
    CHECK(world.colliding_count() == 4);
    cut({6, 7}); // 6, 7, 8: three single pieces, the largest of which collides
    CHECK(debris(6) + debris(7) + debris(8) == 2);
    CHECK(world.colliding_count() == 4);
    CHECK(greatest_speed(world) == 0.0f);
}

TEST_CASE("crowd: a piece whose anchor is released is no debris, and held pieces take no room") {
    WorldSettings settings = empty_space;
    settings.max_colliding = 1;
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

TEST_CASE("crowd: breaks repeat on any number of threads, and below the limit the run equals one without a limit") {
    const auto story = [](WorldSettings settings) {
        World world(settings);
        Destruction destruction;
        BreakableDesc desc = desc_of(0.2);
        desc.motion.placement.position = {0.0f, 0.7f, 0.0f};
        must_add(destruction, world, fracture::cube(1.0), desc);
        Result<Structure> bar =
            Structure::create(world, test::bonded_grid({0.0, 0.0, 0.0}, {1.2, 0.1, 0.1}, 12, 1, 1),
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
    const std::vector<uint64_t> alone = story({.threads = 1, .max_colliding = 20});
    CHECK(alone.back() > 20);
    for (const uint32_t threads : {2u, 3u}) CHECK(story({.threads = threads, .max_colliding = 20}) == alone);
    const std::vector<uint64_t> all = story({.max_colliding = 0});
    CHECK(story({}) == all);
    CHECK(all.back() == 0);
}

TEST_CASE("crowd: a heap of mostly debris comes to rest on the ground and on a fixed shelf") {
    World world({.max_colliding = 30});
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
        CHECK_FALSE(
            (std::abs(local.x) < 0.6f && std::abs(local.y) < 0.03f && std::abs(local.z) < 0.6f)); // inside the shelf
        above += local.y > 0.0f;
    }
    CHECK(above > 30);
}
