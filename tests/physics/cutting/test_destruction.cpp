#include "physics/cutting/destruction.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "tests/physics/bodies.h"
#include "tests/physics/destruction_fixture.h"
#include "tests/physics/run_log.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;
using namespace brittle::physics::test_destruction;
using fracture::PatternKind;

namespace {

// Returns the poses by slot.
std::vector<Pose> poses_of(const Destruction& destruction, const World& world) {
    std::vector<Pose> poses(destruction.slot_count());
    destruction.visit_poses(world, 1.0f, 0, [&](uint32_t slot, const Pose& pose) { poses[slot] = pose; });
    return poses;
}

// Hash of all poses, and of the meshes and depths of the pieces.
uint64_t hash_of(const World& world, const Destruction& destruction) {
    uint64_t hash = world.state_hash();
    const auto add = [&](uint64_t bits) { hash = (hash ^ bits) * 0x100000001b3ull; };
    for (const PieceId piece : destruction.pieces()) {
        add(piece.value);
        add(destruction.depth(piece));
        const SolidPiece& solid = *destruction.solid(piece);
        add(std::bit_cast<uint64_t>(solid.mass.volume));
        for (const glm::vec3& p : solid.surface().positions)
            for (int axis = 0; axis < 3; ++axis) add(std::bit_cast<uint32_t>(p[axis]));
        for (const fracture::Triangle& t : solid.surface().mesh.triangles) add(t.x), add(t.y), add(t.z);
    }
    return hash;
}

// The pieces at their poses in a new world, where they are not siblings: contacts between siblings that move as one
// body are not solved. Hulls are scaled by the factor.
World strangers_of(const World& world, const Destruction& destruction, float factor = 1.0f) {
    WorldSettings settings = empty_space;
    settings.debris_size = 0.0f;
    World apart(settings);
    for (const PieceId piece : destruction.pieces()) {
        const SolidPiece& solid = *destruction.solid(piece);
        BodyDesc desc;
        desc.parts = solid.parts;
        if (factor != 1.0f)
            for (BodyPart& part : desc.parts) part.hull = inflated(*part.hull, factor);
        desc.mass = static_cast<float>(solid.body.mass);
        desc.inertia = glm::mat3(solid.body.inertia);
        desc.pose = world.pose(destruction.body(piece));
        test_bodies::must_add(apart, desc);
    }
    return apart;
}

} // namespace

TEST_CASE("destruction: an invalid object is refused, and the world is unchanged") {
    World world(empty_space);
    Destruction destruction;
    fracture::TriangleMesh open = fracture::cube();
    open.triangles.pop_back();
    CHECK_FALSE(destruction.add(world, open, desc_of(0.1)).has_value());
    CHECK_FALSE(destruction.add(world, fracture::cube(), desc_of(-1.0)).has_value());
    BreakableDesc nowhere = desc_of(0.1);
    nowhere.motion.placement.position.x = std::numeric_limits<float>::quiet_NaN();
    CHECK_FALSE(destruction.add(world, fracture::cube(), nowhere).has_value());
    CHECK(world.body_count() == 0);
    CHECK(destruction.pieces().empty());
    destruction.update(world);
    destruction.remove(world, ObjectId{3});
    CHECK(destruction.take_events().added.empty());
}

TEST_CASE("destruction: invalid blows break nothing") {
    World world(empty_space);
    Destruction destruction;
    must_add(destruction, world, fracture::cube(1.0), desc_of(0.05));
    const PieceId cube = destruction.pieces()[0];
    const float bad = std::numeric_limits<float>::quiet_NaN();
    const glm::vec3 top(0.0f, 0.5f, 0.0f), down(0.0f, -1.0f, 0.0f);
    CHECK_FALSE(destruction.strike(world, cube, {bad, 0.0f, 0.0f}, down, 100.0));
    CHECK_FALSE(destruction.strike(world, cube, top, {0.0f, bad, 0.0f}, 100.0));
    CHECK_FALSE(destruction.strike(world, cube, top, glm::vec3(0.0f), 100.0));
    for (const double energy : {0.0, -5.0, std::numeric_limits<double>::quiet_NaN(), 1e-9})
        CHECK_FALSE(destruction.strike(world, cube, top, down, energy));
    CHECK_FALSE(destruction.strike(world, PieceId{7}, top, down, 100.0));
    run(world, destruction, 5);
    CHECK(world.body_count() == 1);
    CHECK(destruction.statistics().blows == 0);
}

TEST_CASE("destruction: blows to corners, edges, needles and flakes, beside and inside a solid, give valid pieces") {
    for (const glm::dvec3& size : {glm::dvec3(1.0), glm::dvec3(1.0, 1.0, 1e-3), glm::dvec3(2.0, 0.01, 0.01)}) {
        const glm::vec3 half(size * 0.5);
        for (const glm::vec3& at : {half, glm::vec3(half.x, half.y, 0.0f), half * 5.0f, glm::vec3(0.0f)}) {
            World world(empty_space);
            Destruction destruction;
            must_add(destruction, world, fracture::cuboid(size), desc_of(0.002));
            const double volume = volume_of(destruction);
            REQUIRE(destruction.strike(world, destruction.pieces()[0], at, {-1.0f, -0.2f, 0.1f}, 50.0));
            run(world, destruction, 20);
            CHECK(destruction.statistics().failed == 0);
            CHECK(volume_of(destruction) == doctest::Approx(volume).epsilon(1e-9));
            CHECK(all_finite(world));
            CHECK(greatest_speed(world) < 1e-3f);
            CHECK(world.body_count() == destruction.pieces().size());
        }
    }
}

TEST_CASE("destruction: rigid and fixed objects take part, but no blow cuts them" * doctest::test_suite("long")) {
    World world;
    Destruction destruction;
    const fracture::Result<SolidPtr> none = fixed_solid({{{0, 0, 0}, {1, 0, 0}}, {{0, 1, 1}}});
    REQUIRE_FALSE(none.has_value());
    fracture::TriangleMesh table = fracture::cube(2.0);
    table.triangles.erase(table.triangles.begin(), table.triangles.begin() + 2); // open
    const fracture::Result<SolidPtr> surface = fixed_solid(table);
    REQUIRE(surface.has_value());
    BreakableDesc at = desc_of(0.05);
    at.motion.placement.position = {0.0f, 1.0f, 0.0f};
    REQUIRE(destruction.add(world, *surface, at));
    BreakableDesc rigid = desc_of(0.05);
    rigid.solid.breakable = false;
    rigid.motion.placement.position = {0.0f, 2.5f, 0.0f};
    must_add(destruction, world, fracture::cube(0.5), rigid);
    BreakableDesc glass = desc_of(0.05);
    glass.motion.placement.position = {0.0f, 4.0f, 0.0f};
    must_add(destruction, world, fracture::cube(0.5), glass);
    for (const PieceId piece : destruction.pieces()) (void)strike_from_above(world, destruction, piece, 1e5);
    run(world, destruction, 600);
    CHECK(destruction.contains({0}));
    CHECK(destruction.contains({1}));
    CHECK_FALSE(destruction.contains({2}));
    CHECK(world.fixed(destruction.body({0})));
    CHECK(world.pose(destruction.body({0})).position == glm::vec3(0.0f, 1.0f, 0.0f));
    CHECK(volume_of(destruction) == doctest::Approx(2 * 0.125)); // a fixed solid has no volume of its own
    for (const PieceId piece : destruction.pieces())             // on the fixed box, or beside it on the ground
        CHECK(world.pose(destruction.body(piece)).position.y > (piece == PieceId{1} ? 2.2f : 0.0f));
}

TEST_CASE("destruction: in empty space new pieces of any pattern do not move") {
    for (const PatternKind kind :
         {PatternKind::uniform, PatternKind::radial, PatternKind::clustered, PatternKind::splinters})
        for (const char* name : {"cube", "pane", "torus", "animal"}) {
            CAPTURE(name);
            World world(empty_space);
            Destruction destruction;
            BreakableDesc desc = desc_of(0.03);
            desc.pattern.kind = kind;
            must_add(destruction, world, *fracture::shape(name), desc);
            REQUIRE(strike_from_above(world, destruction, destruction.pieces()[0], 200.0));
            run(world, destruction, 3);
            CHECK(destruction.pieces().size() > 5);
            World strangers = strangers_of(world, destruction), larger = strangers_of(world, destruction, 1.05f);
            for (const Drift& stayed : {drift(world, 120, [&] { destruction.update(world); }), drift(strangers, 10)}) {
                CHECK(stayed.speed < 1e-3f);
                CHECK(stayed.way < 1e-6f);
            }
            CHECK(drift(larger, 10).way > 1e-4f); // overlapping hulls do move
        }
}

TEST_CASE("destruction: pieces of a spinning, flying object keep its momentum and angular momentum") {
    World world(empty_space);
    Destruction destruction;
    BreakableDesc desc = desc_of(0.05);
    desc.motion = {.placement = {{3.0f, 1.0f, -2.0f}, glm::normalize(glm::quat(0.7f, 0.1f, 0.5f, -0.3f))},
                   .linear_velocity = {2.0f, -1.0f, 4.0f},
                   .angular_velocity = {1.0f, 3.0f, -2.0f}};
    must_add(destruction, world, fracture::torus(), desc);
    const Mechanics before = world.mechanics();
    REQUIRE(strike_from_above(world, destruction, destruction.pieces()[0], 5000.0));
    world.step(), destruction.update(world);
    CHECK(world.body_count() == 1); // before the commit
    const Mechanics whole = world.mechanics();
    for (uint32_t i = 1; world.body_count() == 1; ++i) {
        REQUIRE(i < 4);
        world.step(), destruction.update(world);
    }
    CHECK(world.body_count() > 20);
    const Mechanics after = world.mechanics();
    CHECK(glm::length(after.momentum - before.momentum) < 1e-4 * glm::length(before.momentum));
    CHECK(glm::length(after.angular_momentum - before.angular_momentum) < 1e-4 * glm::length(before.angular_momentum));
    CHECK(after.kinetic == doctest::Approx(whole.kinetic).epsilon(1e-4));
}

TEST_CASE("destruction: a ball that breaks its target conserves momentum and gains no energy") {
    // 20 kg at v give 24 v N s, an equivalent impulse of 8.8 v; the cube bears 30.
    for (const float speed : {6.0f, 12.0f, 40.0f}) {
        CAPTURE(speed);
        World world(empty_space);
        Destruction destruction;
        must_add(destruction, world, fracture::cube(1.0), desc_of(0.08));
        shoot(world, 0.1f, 20.0f, {0.1f, 0.05f, 2.0f}, {0.0f, 0.0f, -speed});
        const Mechanics before = world.mechanics();
        const auto off = [](const glm::dvec3& a, const glm::dvec3& b) { return glm::length(a - b); };
        double most = before.kinetic;
        for (int step = 0; step < 200; ++step) {
            world.step();
            const Mechanics stepped = world.mechanics();
            destruction.update(world);
            const Mechanics now = world.mechanics();
            most = std::max({most, stepped.kinetic, now.kinetic});
            CHECK(off(now.momentum, before.momentum) < 1e-4 * glm::length(before.momentum));
            // Only the commits: the world's correction of overlaps moves bodies, which changes angular momentum.
            CHECK(off(now.angular_momentum, stepped.angular_momentum) < 1e-4 * glm::length(before.angular_momentum));
        }
        MESSAGE(speed, " m/s: ", destruction.pieces().size(), " pieces, ", destruction.statistics().commits,
                " commits, energy at most ", most / before.kinetic, " of the ball's");
        CHECK(destruction.pieces().size() > 5);
        CHECK(most <= before.kinetic * 1.001);
    }
}

TEST_CASE("destruction: two objects that break each other conserve momentum and gain no energy") {
    World world(empty_space);
    Destruction destruction;
    BreakableDesc desc = desc_of(0.1);
    for (const float side : {-1.0f, 1.0f}) {
        desc.motion = {.placement = {{side * 1.2f, side * 0.2f, 0.1f}, {1, 0, 0, 0}},
                       .linear_velocity = {-side * 8.0f, 0, 0}};
        must_add(destruction, world, fracture::cube(1.0), desc);
    }
    const double energy = world.mechanics().kinetic, scale = 2400.0 * 8.0; // kg m/s, momentum of one object
    const double spin = glm::length(world.mechanics().angular_momentum);
    double most = energy;
    for (int step = 0; step < 60; ++step) {
        world.step();
        const Mechanics stepped = world.mechanics();
        destruction.update(world);
        const Mechanics now = world.mechanics();
        most = std::max({most, stepped.kinetic, now.kinetic});
        CHECK(glm::length(now.momentum) < 1e-4 * scale);
        CHECK(glm::length(now.angular_momentum - stepped.angular_momentum) < 1e-4 * spin);
    }
    MESSAGE(destruction.pieces().size(), " pieces, energy at most ", most / energy, " of the blow's");
    CHECK(destruction.pieces().size() > 10);
    CHECK(most <= energy * 1.001);
}

TEST_CASE("destruction: the seed, the object and its earlier blows decide where a blow cuts") {
    struct Case {
        uint64_t seed = 1;
        int objects_before = 0, blows_before = 0;
    };
    const auto hash_after = [](const Case& chosen) {
        World world(empty_space);
        Destruction destruction;
        BreakableDesc desc = desc_of(0.1);
        desc.pattern.seed = chosen.seed;
        // The sites are so far apart that a weak blow reaches none; its job leaves the object unchanged.
        desc.pattern.diagram = {{0.0, 0.0, 0.0},  {1.0, 0.9, 0.1},  {0.8, 1.0, 1.0},
                                {0.1, 0.95, 0.8}, {0.45, 0.9, 0.2}, {0.3, 0.0, 1.0}};
        for (int k = 0; k < chosen.objects_before; ++k)
            destruction.remove(world, must_add(destruction, world, fracture::cube(1.0), desc));
        must_add(destruction, world, fracture::cube(1.0), desc);
        const PieceId whole = destruction.pieces().front();
        const glm::vec3 top = world.pose(destruction.body(whole)).position + glm::vec3(0.0f, 0.5f, 0.0f);
        for (int k = 0; k < chosen.blows_before; ++k) {
            REQUIRE(destruction.strike(world, whole, top, {0.0f, -1.0f, 0.0f}, 20.0));
            run(world, destruction, 3);
            REQUIRE(destruction.contains(whole));
        }
        REQUIRE(destruction.strike(world, whole, top, {0.0f, -1.0f, 0.0f}, 2000.0));
        run(world, destruction, 3);
        REQUIRE(destruction.pieces().size() > 1);
        CHECK(volume_of(destruction) == doctest::Approx(1.0).epsilon(1e-12));
        uint64_t hash = 0;
        for (const PieceId piece : destruction.pieces())
            hash = hash * 31 + std::bit_cast<uint64_t>(destruction.solid(piece)->mass.volume);
        return hash;
    };
    const uint64_t plain = hash_after({});
    CHECK(hash_after({}) == plain);
    for (const Case& other :
         {Case{.seed = 2}, Case{.objects_before = 1}, Case{.blows_before = 1}, Case{.blows_before = 2}}) {
        const uint64_t hash = hash_after(other);
        CHECK(hash != plain);
        CHECK(hash_after(other) == hash);
    }
    CHECK(hash_after({.blows_before = 2}) != hash_after({.blows_before = 1}));
}

TEST_CASE("destruction: an object breaks along a given diagram") {
    World world(empty_space);
    Destruction destruction;
    BreakableDesc desc = desc_of(0.01);
    desc.pattern.diagram = {{0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 2.0, 0.0}, {0.0, 3.0, 0.0}};
    must_add(destruction, world, fracture::cube(1.0), desc);
    REQUIRE(destruction.strike(world, destruction.pieces()[0], {0.0f, 0.5f, 0.0f}, {0.0f, -1.0f, 0.0f},
                               1e5)); // damages the whole cube
    run(world, destruction, 3);
    // Four sites in a row, fitted to the cube's height: cuts at -1/3, 0 and 1/3 of it.
    std::vector<double> volumes;
    for (const PieceId piece : destruction.pieces()) volumes.push_back(destruction.solid(piece)->mass.volume);
    std::ranges::sort(volumes);
    REQUIRE(volumes.size() == 4);
    CHECK(volumes[0] == doctest::Approx(1.0 / 6.0));
    CHECK(volumes[3] == doctest::Approx(1.0 / 3.0));
}

TEST_CASE("destruction: soft contacts break nothing, hard ones do") {
    const auto pieces_after = [](float speed) {
        World world(empty_space);
        Destruction destruction;
        must_add(destruction, world, fracture::cube(1.0), desc_of(0.05));
        shoot(world, 0.1f, 1.0f, {0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, -speed});
        run(world, destruction, static_cast<int>(60.0f / speed) + 10);
        return destruction.pieces().size();
    };
    // The impulse that stops a kilogram at v is about 1.2 v N s; the cube bears toughness 30 N s/m^2 times 1 m^2.
    CHECK(pieces_after(0.6f) == 1);
    CHECK(pieces_after(15.0f) == 1);
    CHECK(pieces_after(60.0f) > 1);
}

TEST_CASE("destruction: pieces break again down to the minimum size, and volumes sum to the whole") {
    World world(empty_space);
    Destruction destruction;
    RunLog log("a ball, struck again and again");
    INFO(log);
    BreakableDesc desc = desc_of(0.25);
    must_add(destruction, world, fracture::icosphere(3), desc);
    const double volume = volume_of(destruction);
    uint32_t deepest = 0;
    for (int round = 0; round < 6; ++round) {
        const std::vector<PieceId> pieces = destruction.pieces();
        for (const PieceId piece : pieces) strike_from_above(world, destruction, piece, 3000.0);
        log.did("these ", pieces.size(), " are struck from above with 3000 J:", pieces);
        run(world, destruction, 3, &log);
        CHECK(std::abs(volume_of(destruction) - volume) < 1e-9 * volume);
    }
    for (const PieceId piece : destruction.pieces()) {
        deepest = std::max(deepest, destruction.depth(piece));
        CHECK(std::cbrt(destruction.solid(piece)->mass.volume) >= 0.25 * (1.0 - 1e-9));
    }
    MESSAGE(destruction.pieces().size(), " pieces, ", deepest, " levels, ", destruction.statistics().withstood,
            " blows withstood");
    CHECK(deepest >= 3);
    CHECK(destruction.pieces().size() > 50);
    CHECK(destruction.statistics().failed == 0);
    CHECK(greatest_speed(world) < 1e-3f);
}

namespace {

// m^3, the largest parts inside and outside the damage that a blow would make.
std::pair<double, double> chip_and_rest(const PlannedCut& cut) {
    ImpactPattern pattern = cut.desc->pattern;
    pattern.seed = cut.seed;
    ImpactSites sites = impact_sites(cut.solid->surface().mesh, cut.solid->mass, cut.blow, cut.damage, pattern);
    fracture::Settings settings;
    for (const uint32_t group : sites.groups) settings.groups.push_back(group < sites.rest ? 0 : 1);
    const auto parts = fracture::fracture(cut.solid->surface().mesh, sites.sites, settings);
    REQUIRE(parts);
    double chip = 0.0, rest = 0.0;
    for (const fracture::Piece& part : parts->pieces) {
        double& larger = settings.groups[part.site] == 0 ? chip : rest;
        larger = std::max(larger, part.mass.volume);
    }
    return {chip, rest};
}

} // namespace

TEST_CASE("destruction: a piece withstands only where all that would come off is below the minimum size") {
    // A single brick, struck all over by blows whose chips are a few minimum sizes or smaller.
    const glm::dvec3 half = 0.5 * glm::dvec3(0.25, 0.075, 0.1);
    int withstood = 0, together = 0;
    for (const PatternKind kind : {PatternKind::bricks, PatternKind::radial}) {
        World world(empty_space);
        Destruction destruction;
        BreakableDesc desc = desc_of(0.05);
        desc.pattern.kind = kind;
        desc.pattern.bond.corner = -half;
        must_add(destruction, world, fracture::cuboid(2.0 * half), desc);
        const double least = 0.05 * 0.05 * 0.05;
        for (const glm::dvec3& at :
             {glm::dvec3(0.4, 0.3, 1.0), {-0.9, 0.2, 1.0}, {0.3, 0.9, 1.0}, {0.9, 0.8, 1.0}, {0.0, 0.0, 1.0}})
            for (double energy = 1.0; energy < 8.0; energy *= 1.1) {
                const auto cut = destruction.foresee(world, destruction.pieces()[0], glm::vec3(at * half),
                                                     {0.0f, 0.0f, -1.0f}, energy);
                if (!cut) continue;
                const auto pieces = carry_out(*cut);
                REQUIRE(pieces);
                const auto [chip, rest] = chip_and_rest(*cut);
                if (chip >= least && rest >= least) CHECK(pieces->size() > 1);
                withstood += pieces->size() == 1;
                together += pieces->size() == 2 && cut->damage.pieces > 1;
            }
    }
    MESSAGE(withstood, " withstood, of ", together, " one chip came off");
    CHECK(withstood > 10);
    CHECK(together > 20);
}

namespace {

struct Run {
    RunLog log{"an animal falls and is shot at"};
    uint64_t hash = 0;
    std::vector<Commit> commits;
    size_t pieces = 0;
    int steps = 0;
};

// An animal that falls to the ground and is shot at twice. Ends after a number of steps, or with Timing::when_ready
// after three commits.
Run fall(const DestructionSettings& settings, uint32_t threads, int steps = 70, std::span<const Commit> log = {}) {
    World world;
    Destruction destruction(settings);
    destruction.follow(log);
    BreakableDesc desc = desc_of(0.15);
    desc.solid.threads = threads;
    desc.motion.placement.position = {0.0f, 1.5f, 0.0f};
    must_add(destruction, world, fracture::four_legged_animal(24), desc);
    Run result;
    const bool live = settings.timing == Timing::when_ready;
    while (live ? result.commits.size() < 3 : result.steps < steps) {
        const auto shoot_from = [&](const glm::vec3& position, const glm::vec3& velocity) {
            shoot(world, 0.1f, 20.0f, position, velocity);
            result.log.did("a ball is shot from ", position, " at ", velocity, " m/s");
        };
        if (result.steps == 5) shoot_from({0.0f, 2.5f, 2.0f}, {0.0f, 0.0f, -30.0f});
        if (result.steps == 40) shoot_from({2.0f, 2.0f, 0.0f}, {-30.0f, 0.0f, 0.0f});
        if (live)
            std::this_thread::sleep_for(
                std::chrono::milliseconds(1)); // lets the jobs proceed, as a step's real duration would
        world.step();
        destruction.update(world, live ? 1e-5 : 1.0);
        result.commits.insert(result.commits.end(), destruction.commits().begin(), destruction.commits().end());
        result.log.look(world);
        for (const Commit& commit : destruction.commits())
            result.log.did("job ", commit.job, " was committed in this step");
        ++result.steps;
    }
    result.hash = hash_of(world, destruction);
    result.pieces = destruction.pieces().size();
    return result;
}

} // namespace

TEST_CASE("destruction: runs are equal bit for bit with any number of threads" * doctest::test_suite("long")) {
    const Run once = fall({.latency = 3}, 1);
    INFO(once.log);
    MESSAGE(once.pieces, " pieces of ", once.commits.size(), " commits");
    CHECK(once.commits.size() > 3);
    CHECK(fall({.latency = 3}, 2).hash == once.hash);
    const Run many = fall({.latency = 3, .workers = 4}, 4);
    CHECK(many.hash == once.hash);
    CHECK(many.commits == once.commits);
    CHECK(fall({.latency = 4}, 1).hash != once.hash);
    const Run few = fall({.latency = 3, .commits_a_step = 1}, 1);
    for (size_t i = 1; i < few.commits.size(); ++i) CHECK(few.commits[i].step > few.commits[i - 1].step);
}

// Each step commits at least one job, whatever the budget, so the work of a commit must be bounded.
TEST_CASE("destruction: commits a step and bodies a job stay within their limits, and all bodies are prepared") {
    for (const bool by_clock : {false, true}) {
        CAPTURE(by_clock);
        World world(empty_space);
        Destruction destruction(by_clock ? DestructionSettings{.timing = Timing::when_ready, .workers = 2}
                                         : DestructionSettings{.latency = 1, .commits_a_step = 1, .workers = 2});
        BreakableDesc desc = desc_of(0.05);
        desc.max_pieces = 20;
        const SolidPtr ball = *make_solid(fracture::icosphere(2, 0.5), desc.solid);
        for (int k = 0; k < 10; ++k) {
            desc.motion.placement.position = {3.0f * static_cast<float>(k), 0.0f, 0.0f};
            REQUIRE(destruction.add(world, ball, desc));
        }
        (void)destruction.take_events();
        for (const PieceId piece : destruction.pieces()) REQUIRE(strike_from_above(world, destruction, piece, 2e3));
        size_t commits = 0;
        for (int step = 0; destruction.jobs_in_flight() > 0; ++step) {
            REQUIRE(step < 100'000);
            if (by_clock) std::this_thread::sleep_for(std::chrono::milliseconds(1)); // lets the jobs proceed
            world.step();
            const size_t bodies = world.body_count();
            destruction.update(world, 0.0);
            CHECK(destruction.commits().size() <= 1);
            commits += destruction.commits().size();
            // The cells of the damage and the rest. A cell of a ball never falls apart into islands.
            CHECK(world.body_count() <= bodies + destruction.commits().size() * desc.max_pieces);
            size_t vertices = 0;
            for (const PieceAdded& added : destruction.take_events().added) {
                vertices += added.solid->surface().positions.size();
                CHECK_FALSE(added.solid->parts.empty()); // made by the job
                CHECK(added.solid->body.mass > 0.0);
            }
            CHECK(vertices
                  <= destruction.commits().size()
                         * 4000); // vertices: 162 of the ball and those of the cuts; 20 pieces have about 2,000
        }
        CHECK(commits == 10);
        CHECK(destruction.pieces().size() > 50);
    }
}

TEST_CASE("destruction: the log of a run that depends on the clock repeats it") {
    const Run live = fall({.timing = Timing::when_ready, .workers = 2}, 1);
    INFO(live.log);
    const Run again = fall({.timing = Timing::scripted, .workers = 1}, 2, live.steps, live.commits);
    INFO(again.log);
    CHECK(again.commits == live.commits);
    CHECK(again.hash == live.hash);
}

TEST_CASE("destruction: events report every piece once, and slots are reused") {
    World world(empty_space);
    Destruction destruction;
    const ObjectId object = must_add(destruction, world, fracture::cube(1.0), desc_of(0.05));
    std::map<PieceId, uint32_t> shown;
    const auto follow = [&] {
        const DestructionEvents events = destruction.take_events();
        for (const PieceRemoved& removed : events.removed) {
            REQUIRE(shown.contains(removed.id));
            CHECK(shown.at(removed.id) == removed.slot);
            shown.erase(removed.id);
        }
        for (const PieceAdded& added : events.added) {
            CHECK(added.object == object);
            CHECK(added.solid == destruction.solid(added.id));
            CHECK(shown.emplace(added.id, added.slot).second);
        }
        std::vector<uint32_t> slots;
        for (const auto& [id, slot] : shown) slots.push_back(slot);
        std::ranges::sort(slots);
        CHECK(std::ranges::adjacent_find(slots) == slots.end());
        CHECK(slots.size() == destruction.pieces().size());
        const std::vector<Pose> poses = poses_of(destruction, world);
        for (const auto& [id, slot] : shown) {
            REQUIRE(slot < poses.size());
            CHECK(poses[slot].position == world.pose(destruction.body(id)).position);
        }
    };
    follow();
    CHECK(shown.size() == 1);
    for (int round = 0; round < 4; ++round) {
        strike_from_above(world, destruction, largest(destruction), 100.0);
        run(world, destruction, 3);
        if (round != 1) follow(); // skips the events of one round
    }
    CHECK(shown.size() > 10);
    CHECK(destruction.slot_count() <= shown.size() + 1);
    destruction.remove(world, object);
    follow();
    CHECK(shown.empty());
    CHECK(world.body_count() == 0);
}

TEST_CASE("destruction: removing an object, or a body from the world, cancels its jobs") {
    World world(empty_space);
    Destruction destruction({.latency = 5});
    const ObjectId first = must_add(destruction, world, fracture::cube(1.0), desc_of(0.05));
    BreakableDesc beside = desc_of(0.05);
    beside.motion.placement.position = {5.0f, 0.0f, 0.0f};
    must_add(destruction, world, fracture::cube(1.0), beside);
    for (const PieceId piece : destruction.pieces()) CHECK(strike_from_above(world, destruction, piece, 50.0));
    CHECK(destruction.jobs_in_flight() == 2);
    run(world, destruction, 1);
    destruction.remove(world, first);
    CHECK(destruction.jobs_in_flight() == 1);
    world.remove_body(destruction.body(destruction.pieces()[0]));
    run(world, destruction, 10);
    CHECK(destruction.jobs_in_flight() == 0);
    CHECK(destruction.pieces().empty());
    CHECK(destruction.statistics().commits == 0);
    must_add(destruction, world, fracture::cube(1.0), desc_of(0.05));
    CHECK(strike_from_above(world, destruction, destruction.pieces()[0], 50.0)); // its job still runs at the end
}

TEST_CASE("destruction: a blow during a job waits, and hits a piece that the job made") {
    World world(empty_space);
    Destruction destruction({.latency = 4});
    must_add(destruction, world, fracture::cube(1.0), desc_of(0.05));
    const PieceId cube = destruction.pieces()[0];
    CHECK(destruction.strike(world, cube, {0.0f, 0.5f, 0.0f}, {0.0f, -1.0f, 0.0f}, 20.0));
    run(world, destruction, 1);
    CHECK(destruction.strike(world, cube, {0.0f, -0.5f, 0.0f}, {0.0f, 1.0f, 0.0f}, 20.0));
    CHECK(destruction.strike(world, cube, {0.0f, -0.5f, 0.1f}, {0.0f, 1.0f, 0.0f}, 10.0));
    CHECK(destruction.jobs_in_flight() == 1);
    run(world, destruction, 3);
    CHECK(destruction.statistics().commits == 1);
    CHECK(destruction.jobs_in_flight() == 1);
    run(world, destruction, 4);
    CHECK(destruction.statistics().commits == 2);
    uint32_t deepest = 0;
    for (const PieceId piece : destruction.pieces()) deepest = std::max(deepest, destruction.depth(piece));
    CHECK(deepest == 2);
}

TEST_CASE("destruction: a hard blow breaks one piece of a structure, and the others stay bonded") {
    World world(empty_space);
    Destruction destruction;
    std::vector<glm::dvec3> sites;
    for (int i = 0; i < 5; ++i) sites.emplace_back(-0.8 + 0.4 * i, 0.0, 0.0);
    const fracture::Result<fracture::Fragments> bar = fracture::fracture(fracture::cuboid({2.0, 0.4, 0.4}), sites);
    BreakableDesc desc = desc_of(0.05);
    const Result<ObjectId> object =
        destruction.add(world, *bar, {.material = {.tensile = 3e7f, .compressive = 3e8f, .shear = 3e7f}}, desc);
    REQUIRE(object.has_value());
    CHECK(destruction.pieces().size() == 5);
    CHECK(world.body_count() == 1);
    const std::vector<Pose> poses = poses_of(destruction, world);
    for (uint32_t i = 0; i < 5; ++i)
        CHECK(glm::distance(poses[i].position, glm::vec3(-0.8f + 0.4f * static_cast<float>(i), 0.0f, 0.0f)) < 1e-5f);
    CHECK(destruction.strike(world, destruction.pieces()[0], {-1.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, 50.0));
    run(world, destruction, 6);
    CHECK(destruction.pieces().size() > 8);
    CHECK(volume_of(destruction) == doctest::Approx(0.32).epsilon(1e-9));
    const std::vector<PieceId> pieces = destruction.pieces();
    CHECK(destruction.body(pieces[0]) == destruction.body(pieces[3])); // of the four pieces without a hit
    CHECK(destruction.depth(pieces[0]) == 0);
    CHECK(greatest_speed(world) < 1e-3f);
}

TEST_CASE("a joint of a piece that is cut goes on with the part at its anchor") {
    World world({.ground_height = std::nullopt, .air_density = 0.0f, .sleeping = false});
    Destruction destruction;
    const ObjectId object = must_add(destruction, world, fracture::cube(1.0), desc_of(0.1));
    const PieceId whole = destruction.pieces().front();
    const fracture::Box box = fracture::bounds(fracture::cube(1.0));
    const Pose pose = world.pose(destruction.body(whole));
    const float side = static_cast<float>(box.max.y - box.min.y);
    const glm::vec3 top = pose.position + glm::vec3(0.0f, 0.5f * side, 0.0f);
    const Result<JointId> rope = world.add_joint({.kind = JointKind::distance,
                                                  .a = destruction.body(whole),
                                                  .anchor_a = top,
                                                  .anchor_b = top + glm::vec3(0, 1, 0),
                                                  .max_length = 1.0f});
    REQUIRE(rope.has_value());
    const glm::vec3 below = pose.position - glm::vec3(0.0f, 0.5f * side, 0.0f);
    REQUIRE(destruction.strike(world, whole, below, {0, 1, 0}, 2e4));
    run(world, destruction, 10);
    REQUIRE(destruction.pieces().size() > 2);
    REQUIRE(world.has_joint(*rope));
    const BodyId holder = world.joint(*rope).a.body;
    REQUIRE(world.contains(holder));
    run(world, destruction, 240);
    CHECK(world.has_joint(*rope));
    CHECK(glm::length(world.joint_anchor(*rope, false) - world.joint_anchor(*rope, true)) < 1.0f + 1e-3f);
    CHECK(world.pose(holder).position.y > pose.position.y - side); // hangs
    destruction.remove(world, object);
    CHECK(world.joints().empty());
}
