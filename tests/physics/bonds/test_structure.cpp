#include "physics/bonds/structure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "physics/bonds/anchor.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"
#include "tests/physics/run_log.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

Structure must_create(World& world, const fracture::Fragments& fragments, const StructureDesc& desc = {}) {
    Result<Structure> structure = Structure::create(world, fragments, desc);
    REQUIRE_MESSAGE(structure.has_value(), (structure ? std::string() : structure.error().message));
    return std::move(*structure);
}

// Indexed by piece.
std::vector<Pose> poses_of(const Structure& structure, const World& world, float alpha = 1.0f) {
    std::vector<Pose> poses(structure.piece_count());
    structure.visit_poses(world, alpha, 0, [&](uint32_t piece, const Pose& pose) { poses[piece] = pose; });
    return poses;
}

// A bar of cubes of 0.1 m along x.
fracture::Fragments bar(int count) {
    return test::bonded_grid({0.0, 0.0, 0.0}, {0.1 * count, 0.1, 0.1}, count, 1, 1);
}

fracture::Fragments broken_box(int count, uint64_t seed) {
    const fracture::TriangleMesh mesh = fracture::cube(1.0);
    const auto sites = fracture::uniform_sites(fracture::bounds(mesh), static_cast<uint32_t>(count), seed);
    fracture::Result<fracture::Fragments> fragments = fracture::fracture(mesh, sites);
    REQUIRE(fragments.has_value());
    return std::move(*fragments);
}

BodyDesc ball(float radius, float mass, const glm::vec3& position, const glm::vec3& velocity) {
    BodyDesc desc;
    std::vector<glm::dvec3> corners;
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0})
            for (const double z : {-1.0, 1.0}) corners.push_back(static_cast<double>(radius) * glm::dvec3(x, y, z));
    desc.hull = collision_hull(corners, glm::dvec3(0.0));
    desc.mass = mass;
    desc.inertia = glm::mat3(mass * radius * radius * 2.0f / 3.0f);
    desc.pose.position = position;
    desc.linear_velocity = velocity;
    return desc;
}

double off(const glm::dvec3& now, const glm::dvec3& before) {
    return glm::length(now - before) / glm::length(before);
}

} // namespace

TEST_CASE("an invalid structure is refused and leaves the world unchanged") {
    World world;
    const fracture::Fragments good = bar(3);
    CHECK_FALSE(Structure::create(world, good, {.anchored = {3}}).has_value());
    CHECK_FALSE(Structure::create(world, good, {.material = {.density = 0.0f}}).has_value());
    CHECK_FALSE(Structure::create(world, good, {.material = {.tensile = -1.0f}}).has_value());
    CHECK_FALSE(Structure::create(world, good, {.material = {.restitution = 2.0f}}).has_value());
    fracture::Fragments bad = good;
    bad.positions[9].y = std::numeric_limits<double>::infinity();
    CHECK_FALSE(Structure::create(world, bad).has_value());
    CHECK(world.body_count() == 0);
    CHECK(must_create(world, {}).bodies().empty());
}

TEST_CASE("bonds to missing pieces and bonds without area are broken from the start") {
    fracture::Fragments fragments = bar(3);
    fragments.bonds[0].b = 7;
    fragments.bonds[1].area = 0.0;
    World world(empty_space);
    const Structure structure = must_create(world, fragments);
    CHECK(world.body_count() == 3);
    CHECK(structure.graph().live_count() == 0);
}

TEST_CASE("a grain of dust that comes off a structure becomes a body") {
    // The bisector cuts a corner of 10 nm to 1 mm off a cube of 1 m.
    for (const double side : {1e-8, 1e-7, 1e-6, 1e-5, 1e-3}) {
        CAPTURE(side);
        const glm::dvec3 far(1.0 - side / 1.5);
        const fracture::Fragments fragments =
            *fracture::fracture(fracture::cube(1.0), std::vector{glm::dvec3(0.0), far});
        REQUIRE(fragments.pieces.size() == 2);
        REQUIRE(fragments.bonds.size() == 1);
        const uint32_t dust = fragments.pieces[0].mass.volume < fragments.pieces[1].mass.volume ? 0 : 1;
        CHECK(fragments.pieces[dust].mass.volume == doctest::Approx(side * side * side / 6.0).epsilon(0.05));
        for (const EngineKind engine : {EngineKind::solver, EngineKind::bullet}) {
            World world({.engine = engine});
            Structure structure =
                must_create(world, fragments, {.motion = {.placement = {.position = {0.0f, 1.0f, 0.0f}}}});
            REQUIRE(world.body_count() == 1);
            structure.isolate(dust);
            structure.update(world);
            CHECK(world.body_count() == 2);
            CHECK(structure.body_of(dust) != structure.body_of(1 - dust));
            for (int step = 0; step < 60; ++step) {
                world.step();
                structure.update(world);
            }
            for (const BodyId body : world.bodies()) CHECK(std::isfinite(glm::length(world.pose(body).position)));
        }
    }
}

TEST_CASE("bonded pieces are one body with the mass and inertia of the whole") {
    World world(empty_space);
    const fracture::Fragments fragments = broken_box(40, 3);
    const PlacedMotion motion{.placement = {{1.0f, 2.0f, 3.0f}, glm::normalize(glm::quat(0.9f, 0.2f, 0.3f, -0.1f))},
                              .angular_velocity = {1.0f, -2.0f, 0.5f}};
    const Structure structure = must_create(world, fragments, {.material = {.density = 1000.0f}, .motion = motion});
    REQUIRE(world.body_count() == 1);
    const BodyId body = structure.body_of(0);
    CHECK(world.mass(body) == doctest::Approx(1000.0).epsilon(1e-6));
    CHECK(glm::length(world.pose(body).position - glm::vec3(1.0f, 2.0f, 3.0f)) < 1e-6f);
    // A cube's inertia is m / 6 about any axis.
    const double energy = 0.5 * 1000.0 / 6.0 * (1.0 + 4.0 + 0.25);
    CHECK(world.mechanics().kinetic == doctest::Approx(energy).epsilon(1e-5));

    // Pieces are where add_pieces() would put them.
    World apart(empty_space);
    REQUIRE(add_pieces(apart, fragments, {}, motion).has_value());
    const std::vector<Pose> poses = poses_of(structure, world), expected = poses_of(apart);
    REQUIRE(poses.size() == expected.size());
    for (size_t i = 0; i < poses.size(); ++i) {
        CHECK(glm::length(poses[i].position - expected[i].position) < 1e-6f);
        CHECK(std::abs(glm::dot(poses[i].orientation, expected[i].orientation)) > 0.999999f);
        const glm::vec3 in_body =
            world.pose(body).position + world.pose(body).orientation * structure.offset(static_cast<uint32_t>(i));
        CHECK(glm::length(poses[i].position - in_body) < 1e-6f);
    }
}

TEST_CASE("a thousand bonded pieces in empty space stay at rest, also when all bonds are cut") {
    WorldSettings settings = empty_space;
    settings.max_colliding = 0;
    World world(settings);
    const fracture::Fragments fragments = broken_box(1000, 5);
    Structure structure = must_create(world, fragments);
    REQUIRE(world.body_count() == 1);
    const std::vector<Pose> before = poses_of(structure, world);
    for (int step = 0; step < 30; ++step) world.step(), structure.update(world);
    CHECK(world.body_count() == 1);
    CHECK(world.mechanics().kinetic == 0.0);
    std::vector<uint32_t> bonds(structure.graph().bonds().size());
    std::iota(bonds.begin(), bonds.end(), 0u);
    structure.break_bonds(bonds);
    const Structure::Changes& changes = structure.update(world);
    CHECK(changes.added.size() == fragments.pieces.size());
    CHECK(changes.removed.size() == 1);
    for (int step = 0; step < 5; ++step) world.step(), structure.update(world);
    const std::vector<Pose> after = poses_of(structure, world);
    for (size_t i = 0; i < before.size(); ++i) CHECK(glm::length(after[i].position - before[i].position) < 1e-6f);
}

TEST_CASE(
    "islands of a body that splits in the air have no mutual contacts while they fly in formation, and have them on "
    "the ground") {
    const fracture::Fragments fragments = broken_box(200, 3);
    for (const bool flies : {true, false}) {
        CAPTURE(flies);
        World world({.air_density = 0.0f});
        StructureDesc desc;
        desc.motion.placement.position.y = flies ? 5.0f : 0.51f; // the cube is centred at the origin
        desc.motion.linear_velocity = flies ? glm::vec3(3.0f, 1.0f, 0.0f) : glm::vec3(0.0f);
        Structure structure = must_create(world, fragments, desc);
        world.step();
        std::vector<uint32_t> bonds(structure.graph().bonds().size());
        std::iota(bonds.begin(), bonds.end(), 0u);
        structure.break_bonds(bonds);
        structure.update(world);
        REQUIRE(world.body_count() == fragments.pieces.size());
        const Pose before = world.pose(world.bodies()[0]);
        for (int i = 0; i < 10; ++i) world.step();
        if (!flies) {
            CHECK(world.contact_count() > 500);
            continue;
        }
        CHECK(world.contact_count() == 0);
        const glm::vec3 way = world.pose(world.bodies()[0]).position - before.position;
        CHECK(way.x == doctest::Approx(3.0 * 10.0 / 120.0).epsilon(1e-4));
        for (uint32_t i = 0; i < fragments.pieces.size(); ++i) {
            const glm::vec3 now = world.pose(structure.body_of(i)).position - world.pose(structure.body_of(0)).position;
            const glm::dvec3 then = fragments.pieces[i].mass.centre_of_mass - fragments.pieces[0].mass.centre_of_mass;
            CHECK(glm::distance(glm::dvec3(now), then) < 1e-5);
        }
    }
}

TEST_CASE("a bar cut in the middle becomes two bodies in place, by a list of bonds or by a saw") {
    for (const bool saw : {false, true}) {
        World world(empty_space);
        const fracture::Fragments fragments = bar(6);
        Structure structure = must_create(world, fragments, {.motion = {.angular_velocity = {0.0f, 0.0f, 2.0f}}});
        for (int step = 0; step < 20; ++step) world.step();
        const std::vector<Pose> before = poses_of(structure, world), early = poses_of(structure, world, 0.5f);
        if (saw) {
            const Pose pose = world.pose(structure.body_of(0));
            const auto at = [&](float z) { return pose.position + pose.orientation * glm::vec3(0.0f, 0.03f, z); };
            structure.damage_segment(world, at(-0.2f), at(0.2f), 0.01f);
        } else {
            structure.break_bonds(std::array{2u});
        }
        CHECK(world.body_count() == 1);
        const Structure::Changes& changes = structure.update(world);
        CHECK(changes.broken == std::vector<uint32_t>{2});
        CHECK(world.body_count() == 2);
        CHECK(structure.body_of(0) == structure.body_of(2));
        CHECK(structure.body_of(3) == structure.body_of(5));
        CHECK(structure.bodies() == changes.added);
        std::vector<Pose> after = poses_of(structure, world);
        for (size_t i = 0; i < 6; ++i) CHECK(glm::length(after[i].position - before[i].position) < 1e-6f);
        after = poses_of(structure, world, 0.5f);
        for (size_t i = 0; i < 6; ++i) CHECK(glm::length(after[i].position - early[i].position) < 1e-5f);
        CHECK(structure.update(world).added.empty());
    }
}

TEST_CASE("a hundred random sequences of breaks conserve momentum and angular momentum") {
    double worst = 0.0, worst_turn = 0.0;
    for (uint64_t seed = 1; seed <= 100; ++seed) {
        test::Random random(seed);
        RunLog log("a flying cube of twenty pieces, seed " + std::to_string(seed));
        INFO(log);
        World world(empty_space);
        const fracture::Fragments fragments = broken_box(20, seed);
        const PlacedMotion motion{.placement = {glm::vec3(random.point(glm::dvec3(-2.0), glm::dvec3(2.0))),
                                                glm::quat(0.6f, 0.0f, 0.8f, 0.0f)},
                                  .linear_velocity = glm::vec3(random.point(glm::dvec3(-5.0), glm::dvec3(5.0))),
                                  .angular_velocity = glm::vec3(random.direction() * 8.0)};
        Structure structure = must_create(world, fragments, {.motion = motion});
        for (int round = 0; round < 4; ++round) {
            std::vector<uint32_t> bonds(40);
            for (uint32_t& bond : bonds)
                bond = static_cast<uint32_t>(random.uniform(0.0, 0.999)
                                             * static_cast<double>(structure.graph().bonds().size()));
            for (const uint32_t bond : bonds) structure.break_bonds(std::array{bond});
            log.did("these bonds are broken:", bonds);
            const Mechanics before = world.mechanics();
            structure.update(world);
            const Mechanics after = world.mechanics();
            worst = std::max(worst, off(after.momentum, before.momentum));
            worst_turn = std::max(worst_turn, off(after.angular_momentum, before.angular_momentum));
            CHECK(after.kinetic <= before.kinetic * (1.0 + 1e-4));
            for (int step = 0; step < 3; ++step) world.step(), log.look(world);
        }
        CHECK(world.body_count() > 1);
    }
    MESSAGE("worst relative change of momentum ", worst, ", of angular momentum ", worst_turn);
    CHECK(worst < 1e-4);
    CHECK(worst_turn < 1e-4);
}

TEST_CASE("anchored pieces stay, pieces cut off from them fall, and released pieces fall") {
    World world;
    const fracture::Fragments fragments = bar(5);
    const Pose placement{{0.0f, 1.0f, 0.0f}, {1.0f, 0.0f, 0.0f, 0.0f}};
    Structure structure = must_create(world, fragments, {.motion = {.placement = placement}, .anchored = {0}});
    const auto run = [&](float seconds) {
        for (int i = 0; i < static_cast<int>(seconds * 120.0f); ++i) world.step(), structure.update(world);
    };
    run(1.0f);
    CHECK(world.fixed(structure.body_of(4)));
    structure.break_bonds(std::array{1u});
    run(1.0f);
    std::vector<Pose> poses = poses_of(structure, world);
    CHECK(poses[0].position.y == doctest::Approx(1.05));
    CHECK(poses[1].position.y == doctest::Approx(1.05));
    CHECK(world.fixed(structure.body_of(1)));
    CHECK_FALSE(world.fixed(structure.body_of(2)));
    CHECK(poses[3].position.y < 0.2f);
    CHECK(poses[3].position.y > 0.03f);
    CHECK(structure.anchored(0));
    structure.release_anchors(std::array{0u});
    run(1.0f);
    CHECK_FALSE(structure.anchored(0));
    poses = poses_of(structure, world);
    CHECK(poses[0].position.y < 0.3f);
    CHECK(world.body_count() >= 2);
}

TEST_CASE("damage is full at the point, decreases to zero at the radius, and accumulates") {
    World world(empty_space);
    const fracture::Fragments fragments = bar(9);
    Structure structure = must_create(world, fragments, {.motion = {.placement = {{5.0f, 0.0f, 0.0f}, {1, 0, 0, 0}}}});
    structure.damage(world, {5.1f, 0.05f, 0.05f}, 0.4f, 0.8f); // at the first bond
    const auto bonds = structure.graph().bonds();
    CHECK(bonds[0].health == doctest::Approx(0.2));
    CHECK(bonds[1].health == doctest::Approx(0.4));
    CHECK(bonds[2].health == doctest::Approx(0.6));
    CHECK(bonds[3].health == doctest::Approx(0.8));
    CHECK(bonds[4].health == doctest::Approx(1.0));
    CHECK(structure.update(world).broken.empty());
    structure.damage(world, {5.1f, 0.05f, 0.05f}, 0.4f, 0.8f);
    CHECK(structure.update(world).broken == std::vector<uint32_t>{0, 1});
    CHECK(world.body_count() == 3);
}

TEST_CASE("a blow breaks out the piece that it hits, and a harder blow also the pieces behind") {
    // A bond of 0.01 m^2 bears 1 N s in tension and shear, and in compression too, as the tensile strength is the
    // smaller.
    const Material material{.tensile = 1e6f, .compressive = 1e7f, .shear = 1e6f, .fracture_energy = 1e-3f};
    for (const auto& [case_impulse, broken] : {std::pair(0.05f, 0u), {1.5f, 0u}, {2.5f, 2u}, {9.0f, 4u}}) {
        const auto impulse = case_impulse; // clang 14 captures no structured binding
        World world(empty_space);
        Structure structure = must_create(world, bar(7), {.material = material});
        structure.blow(world, 3, {0.0f, impulse, 0.0f});
        CAPTURE(impulse);
        CHECK(structure.update(world).broken.size() == broken);
        if (impulse == 0.05f) CHECK(structure.graph().bonds()[2].health == 1.0);
        if (impulse == 1.5f) CHECK(structure.graph().bonds()[2].health == doctest::Approx(0.25));
    }
    World world(empty_space);
    Structure structure = must_create(world, bar(7), {.material = material});
    structure.blow(world, 3, {1.0f, 0.0f, 0.0f}); // tension in one bond, compression in the other
    CHECK(structure.graph().bonds()[2].health == doctest::Approx(0.5));
    CHECK(structure.graph().bonds()[3].health == doctest::Approx(0.5));
    structure.blow(world, 0, {-0.8f, 0.0f, 0.0f});
    CHECK(structure.graph().bonds()[0].health == doctest::Approx(0.2));
    structure.blow(world, 6, {-0.09f, 0.0f, 0.0f}); // less than a tenth of the bond's strength
    CHECK(structure.graph().bonds()[5].health == 1.0);
    // A material that is weaker in compression than in tension.
    Material soft = material;
    soft.compressive = 5e5f;
    World other(empty_space);
    Structure presses = must_create(other, bar(7), {.material = soft});
    presses.blow(other, 0, {0.25f, 0.0f, 0.0f});
    presses.blow(other, 6, {0.25f, 0.0f, 0.0f});
    CHECK(presses.graph().bonds()[0].health == doctest::Approx(0.5));
    CHECK(presses.graph().bonds()[5].health == doctest::Approx(0.75));
}

TEST_CASE("a blow breaks no more bonds than its energy pays for, so weak but tough bonds hold longer") {
    // Each blow has 800 J (a striker of 1 kg) and impulse enough for the whole bar. A bond costs 0.01 m^2 * fracture
    // energy.
    for (const auto& [case_fracture_energy, broken, left] :
         {std::tuple(1e3f, 6u, 0.0), {1.9e4f, 4u, 0.0}, {5e4f, 0u, 0.2}, {5e5f, 0u, 0.92}}) {
        const auto fracture_energy = case_fracture_energy; // clang 14 captures no structured binding
        CAPTURE(fracture_energy);
        World world(empty_space);
        Structure structure = must_create(
            world, bar(7),
            {.material = {.tensile = 1e5f, .compressive = 1e6f, .shear = 1e5f, .fracture_energy = fracture_energy}});
        structure.blow(world, 3, {0.0f, 40.0f, 0.0f});
        double spent = 0.0;
        for (const BondGraph::Bond& bond : structure.graph().bonds())
            spent += (1.0 - bond.health) * bond.area * static_cast<double>(fracture_energy);
        CHECK(spent <= 800.0 * (1.0 + 1e-6));
        CHECK(structure.update(world).broken.size() == broken);
        if (broken < 6) CHECK(spent == doctest::Approx(800.0));
        if (broken == 0) CHECK(structure.graph().bonds()[2].health == doctest::Approx(left));
    }
}

TEST_CASE("a blow whose energy the bonds absorb is no Impact on the piece") {
    // The ball has 200 J. `costs` is the energy, J, that breaks the four bonds of the piece that it hits.
    for (const auto& [case_costs, told] : {std::pair(2000.0f, false), {2.0f, true}}) {
        const auto costs = case_costs; // clang 14 captures no structured binding
        World world(empty_space);
        const fracture::Fragments pane = test::bonded_grid({-0.5, -0.5, -0.01}, {0.5, 0.5, 0.01}, 5, 5, 1);
        const Material glass{.density = 2500.0f, .tensile = 1e6f, .fracture_energy = costs / (4 * 0.2f * 0.02f)};
        Structure structure = must_create(world, pane, {.material = glass});
        must_add(world, ball(0.05f, 4.0f, {0.02f, 0.01f, 0.5f}, {0.0f, 0.0f, -10.0f}));
        size_t broken = 0;
        float energy = 0.0f;
        for (int step = 0; step < 60; ++step) {
            world.step();
            const Structure::Changes& changes = structure.update(world);
            broken += changes.broken.size();
            for (const Impact& impact : changes.impacts) energy += impact.energy;
        }
        CAPTURE(costs);
        CHECK((broken > 0) == told);
        CHECK((energy > 0.0f) == told);
        CHECK(energy < 200.0f);
    }
}

TEST_CASE("a ball breaks a piece out of a pane and flies on, and momentum is conserved") {
    for (const bool anchored : {false, true}) {
        World world(empty_space);
        const fracture::Fragments pane = test::bonded_grid({-0.5, -0.5, -0.01}, {0.5, 0.5, 0.01}, 5, 5, 1);
        StructureDesc desc{.material = {.density = 2500.0f, .tensile = 1e6f, .fracture_energy = 500.0f}};
        if (anchored) desc.anchored = {0, 4, 20, 24};
        Structure structure = must_create(world, pane, desc);
        const BodyId flying = *world.add_body(ball(0.05f, 4.0f, {0.02f, 0.01f, 0.5f}, {0.0f, 0.0f, -10.0f}));
        const Mechanics before = world.mechanics();
        size_t broken = 0, impacts = 0;
        for (int step = 0; step < 60; ++step) {
            const double energy = world.mechanics().kinetic;
            world.step();
            const Structure::Changes& changes = structure.update(world);
            broken += changes.broken.size();
            for (const Impact& impact : changes.impacts) {
                ++impacts;
                if (impact.other != flying || impacts > 1) continue;
                CHECK(impact.normal.z < -0.9f);
                CHECK(impact.energy > 0.0f);
                CHECK(std::abs(impact.point.x) < 0.2f);
            }
            CHECK(world.mechanics().kinetic < energy * 1.001 + 1e-6);
        }
        const Mechanics after = world.mechanics();
        CAPTURE(anchored);
        CHECK(broken >= 4);
        CHECK(impacts >= 1);
        // The piece of 2 kg takes a share of the momentum; the ball of 4 kg flies on through the gap.
        CHECK(world.linear_velocity(flying).z < -2.0f);
        CHECK(world.pose(flying).position.z < -0.1f);
        CHECK(world.linear_velocity(structure.body_of(12)).z < -2.0f);
        if (anchored) {
            CHECK(world.fixed(structure.body_of(0)));
            CHECK(std::abs(world.pose(structure.body_of(0)).position.z) < 1e-6f);
        } else {
            CHECK(off(after.momentum, before.momentum) < 1e-4);
            CHECK(glm::length(after.angular_momentum - before.angular_momentum) < 3e-2); // from overlap correction
        }
    }
}

TEST_CASE("a structure that falls breaks, and one at rest does not wear") {
    World world;
    const Material weak{.tensile = 2e5f};
    Structure resting = must_create(
        world, bar(8),
        {.material = weak, .motion = {.placement = {{0, 0, 1}, {1, 0, 0, 0}}}, .wear = {.strength_scale = 1.0f}});
    const glm::quat tilted = glm::angleAxis(0.3f, glm::vec3(0.0f, 0.0f, 1.0f));
    Structure falling = must_create(world, bar(8), {.material = weak, .motion = {.placement = {{0, 2, -1}, tilted}}});
    for (int step = 0; step < 240; ++step) world.step(), resting.update(world), falling.update(world);
    CHECK(resting.bodies().size() == 1);
    CHECK(resting.graph().live_count() == 7);
    CHECK(falling.bodies().size() > 1);
}

namespace {

// A slab of 1 m x 1 m on four columns of cubes of 0.2 m under its corners.
struct Table {
    fracture::Fragments fragments;
    std::vector<uint32_t> second_blocks; // of the columns at x = 0

    Table() {
        const auto add = [&](const glm::dvec3& low, const glm::dvec3& high) {
            test::append_piece(fragments, test::box_polyhedron(low, high));
            return static_cast<uint32_t>(fragments.pieces.size() - 1);
        };
        const auto bond = [&](uint32_t a, uint32_t b, double area, const glm::dvec3& at, const glm::dvec3& normal) {
            fragments.bonds.push_back({a, b, area, at, normal});
        };
        std::vector<uint32_t> slab;
        for (int i = 0; i < 5; ++i)
            for (int k = 0; k < 5; ++k)
                slab.push_back(add({0.2 * i, 0.8, 0.2 * k}, {0.2 * i + 0.2, 1.0, 0.2 * k + 0.2}));
        const auto at = [&](int i, int k) { return slab[static_cast<size_t>(i * 5 + k)]; };
        for (int i = 0; i < 5; ++i)
            for (int k = 0; k < 5; ++k) {
                if (i < 4) bond(at(i, k), at(i + 1, k), 0.04, {0.2 * i + 0.2, 0.9, 0.2 * k + 0.1}, {1, 0, 0});
                if (k < 4) bond(at(i, k), at(i, k + 1), 0.04, {0.2 * i + 0.1, 0.9, 0.2 * k + 0.2}, {0, 0, 1});
            }
        for (const int i : {0, 4})
            for (const int k : {0, 4}) {
                uint32_t below = UINT32_MAX;
                for (int j = 0; j < 4; ++j) {
                    const glm::dvec3 low(0.2 * i, 0.2 * j, 0.2 * k);
                    const uint32_t block = add(low, low + 0.2);
                    if (i == 0 && j == 1) second_blocks.push_back(block);
                    if (j > 0) bond(below, block, 0.04, low + glm::dvec3(0.1, 0.0, 0.1), {0, 1, 0});
                    below = block;
                }
                bond(below, at(i, k), 0.04, {0.2 * i + 0.1, 0.8, 0.2 * k + 0.1}, {0, 1, 0});
            }
    }
};

} // namespace

TEST_CASE("a table stands for ten seconds, and falls within one second when two of its columns lose a block") {
    const Table table;
    World world;
    Structure structure = must_create(
        world, table.fragments, {.anchored = anchor_to_ground(table.fragments), .wear = {.strength_scale = 0.02f}});
    for (int step = 0; step < 1200; ++step) {
        world.step();
        REQUIRE(structure.update(world).broken.empty());
    }
    CHECK(world.body_count() == 1);
    double worst = 0.0;
    for (const double ratio : structure.wear().ratios()) worst = std::max(worst, ratio);
    MESSAGE("the highest load ratio of the table is ", worst);
    CHECK(worst > 0.1);
    CHECK(worst < 1.0);
    for (const uint32_t block : table.second_blocks) {
        structure.isolate(block);
        structure.update(world);
        CHECK(structure.take_piece(world, block).has_value());
    }
    int step = 0;
    for (; step < 240; ++step) {
        world.step();
        structure.update(world);
        if (poses_of(structure, world)[0].position.y < 0.7f) break;
    }
    MESSAGE("down after ", step / 120.0, " s");
    CHECK(step < 120);
}

TEST_CASE("a heavy resting load breaks a cantilever, and a light one does not") {
    for (const float mass : {20.0f, 1000.0f}) {
        World world;
        const fracture::Fragments fragments = bar(6);
        Structure structure = must_create(world, fragments,
                                          {.motion = {.placement = {{0, 1, 0}, {1, 0, 0, 0}}},
                                           .anchored = {0},
                                           .wear = {.strength_scale = 1.0f / 3.0f}});
        REQUIRE(world.add_body(ball(0.05f, mass, {0.45f, 1.1501f, 0.05f}, {})).has_value());
        size_t broken = 0;
        for (int i = 0; i < 360; ++i) {
            world.step();
            broken += structure.update(world).broken.size();
            if (i == 300 && mass < 100.0f) {
                // About the bond at the wall: 20 kg at 0.35 m and five blocks of 2.4 kg at 0.25 m.
                const double moment = 9.81 * (20.0 * 0.35 + 12.0 * 0.25);
                const double ratio = moment * 7.0898 / 0.001 / (3e6 / 3.0);
                CHECK(structure.wear().ratios()[0] == doctest::Approx(ratio).epsilon(0.1));
                CHECK(ratio < 1.0);
            }
        }
        CAPTURE(mass);
        CHECK((broken > 0) == (mass > 100.0f));
    }
}

TEST_CASE("two cubes that break on each other and on the ground gain no energy" * doctest::test_suite("long")) {
    for (uint64_t seed = 3; seed < 9; ++seed) {
        RunLog log("two cubes of a hundred pieces, seed " + std::to_string(seed));
        INFO(log);
        World world;
        const fracture::Fragments fragments = broken_box(100, seed);
        const auto tilt = static_cast<float>(seed) * 0.4f;
        const auto at = [&](float height) {
            const glm::quat turned = glm::normalize(glm::quat(0.9f, 0.2f, 0.1f * tilt, 0.3f));
            return PlacedMotion{.placement = {{0.1f * height, height, 0.0f}, turned}};
        };
        Structure below = must_create(world, fragments, {.motion = at(1.5f)});
        Structure above = must_create(world, fragments, {.motion = at(4.0f)});
        EnergyBooks energy(world);
        double rise_of_break = 0.0;
        for (int step = 0; step < 600; ++step) {
            const double before = energy.last;
            world.step();
            const double moved = energy_of(world);
            below.update(world), above.update(world);
            log.look(world);
            energy.look(world);
            rise_of_break = std::max(rise_of_break, energy.last - std::max(moved, before));
        }
        MESSAGE("energy, as a share of its start: sum of all rises ", energy.risen / energy.start,
                ", highest above an earlier minimum ", energy.max_above_min / energy.start,
                ", highest rise in a break ", rise_of_break / energy.start);
        CHECK(rise_of_break < 1e-6 * energy.start);
        // Bounds on solver residuals; observed were 4.5e-4 above the minimum and 9.5e-4 in all.
        CHECK(energy.steepest < 1e-3 * energy.start);
        CHECK(energy.max_above_min < 2e-3 * energy.start);
        CHECK(energy.risen < 4e-3 * energy.start);
        CHECK(energy.last < 0.5 * energy.start);
        CHECK(world.body_count() > 4);
    }
}

TEST_CASE("a body that came off can be removed with all its pieces while the anchored rest goes on") {
    World world;
    Structure structure =
        must_create(world, bar(7), {.motion = {.placement = {{0.0f, 0.3f, 0.0f}}}, .anchored = {0, 6}});
    CHECK_FALSE(structure.is_detached(1));
    CHECK(structure.pieces_of_body(3).size() == 7);
    structure.break_bonds(std::array{2u, 5u});
    structure.update(world);
    REQUIRE(world.body_count() == 3);
    for (uint32_t piece = 0; piece < 7; ++piece) CHECK(structure.is_detached(piece) == (piece >= 3 && piece <= 5));
    CHECK(std::ranges::equal(structure.pieces_of_body(4), std::array{3u, 4u, 5u}));
    const BodyId hammer = *world.add_body(ball(0.05f, 1.0f, {0.45f, 0.47f, 0.05f}, {0.0f, -10.0f, 0.0f}));
    const auto is_hit = [&](const Contact& contact) { return contact.a == hammer || contact.b == hammer; };
    for (int step = 0; std::ranges::none_of(world.contacts(), is_hit); ++step) {
        REQUIRE(step < 20);
        structure.update(world);
        world.step();
    }
    structure.remove_body(world, 4); // after the blow, before update() sees it
    CHECK(world.body_count() == 3);
    CHECK(structure.bodies().size() == 2);
    CHECK(structure.graph().live_count() == 2);
    CHECK(structure.update(world).broken.size() == 2);
    for (const uint32_t piece : {3u, 4u, 5u}) {
        CHECK(structure.body_of(piece) == BodyId{});
        CHECK(structure.pieces_of_body(piece).empty());
        CHECK_FALSE(structure.is_detached(piece));
        structure.remove_body(world, piece);
        structure.isolate(piece);
        structure.blow(world, piece, {0.0f, -100.0f, 0.0f});
        structure.release_anchors(std::array{piece});
    }
    structure.damage(world, {0.35f, 0.35f, 0.05f}, 0.1f, 1.0f);
    for (int step = 0; step < 240; ++step) {
        world.step();
        REQUIRE(structure.update(world).broken.empty());
    }
    CHECK(structure.wear().solver().converged());
    for (const uint32_t gone : {2u, 3u, 4u, 5u}) CHECK(structure.wear().ratios()[gone] == 0.0);
    CHECK(structure.wear().ratios()[1] > 0.0);
    CHECK(world.body_count() == 3);
}

TEST_CASE("a piece can be taken out, and the parts that it is cut into continue its motion") {
    World world(empty_space);
    const fracture::Fragments fragments = bar(3);
    const PlacedMotion motion{.placement = {{1.0f, 0.5f, 0.0f}, glm::angleAxis(0.7f, glm::vec3(0.0f, 1.0f, 0.0f))},
                              .linear_velocity = {0.5f, 0.0f, 0.0f},
                              .angular_velocity = {0.0f, 3.0f, 1.0f}};
    Structure structure = must_create(world, fragments, {.motion = motion});
    CHECK_FALSE(structure.take_piece(world, 1).has_value());
    for (int step = 0; step < 30; ++step) world.step();
    structure.isolate(1);
    structure.update(world);
    CHECK(world.body_count() == 3);
    const Mechanics before = world.mechanics();
    const std::vector<Pose> poses = poses_of(structure, world);
    const std::optional<PlacedMotion> taken = structure.take_piece(world, 1);
    REQUIRE(taken.has_value());
    CHECK(world.body_count() == 2);
    CHECK(structure.body_of(1) == BodyId{});
    CHECK_FALSE(structure.take_piece(world, 1).has_value());
    // The middle block cut in four, in the coordinates of the fragments.
    const fracture::Fragments parts = test::bonded_grid({0.1, 0.0, 0.0}, {0.2, 0.1, 0.1}, 1, 2, 2);
    Structure crumbs = must_create(world, parts, {.motion = *taken});
    const Mechanics after = world.mechanics();
    CHECK(off(after.momentum, before.momentum) < 1e-4);
    CHECK(off(after.angular_momentum, before.angular_momentum) < 1e-4);
    CHECK(glm::length(world.pose(crumbs.body_of(0)).position - poses[1].position) < 1e-5f);
    structure.remove(world);
    CHECK(world.body_count() == 1);
}

TEST_CASE("a structure survives the removal of its bodies from the world") {
    World world;
    Structure structure = must_create(world, bar(4), {.motion = {.placement = {{0, 1, 0}, {1, 0, 0, 0}}}});
    structure.break_bonds(std::array{1u});
    structure.update(world);
    CHECK(world.remove_body(structure.body_of(0)));
    structure.damage(world, {0.3f, 1.0f, 0.0f}, 1.0f, 2.0f);
    structure.update(world);
    CHECK(world.body_count() == 2);
    std::vector<uint32_t> there;
    const auto visit = [&](uint32_t piece, const Pose&) { there.push_back(piece); };
    structure.visit_poses(world, 1.0f, 0, visit);
    CHECK(there == std::vector<uint32_t>{2, 3});
    world.clear();
    world.step();
    structure.update(world);
    there.clear();
    structure.visit_poses(world, 1.0f, 0, visit);
    CHECK(there.empty());
}

TEST_CASE("equal breaks reproduce equal states") {
    const auto play = [](World& world) {
        const fracture::Fragments fragments = broken_box(60, 9);
        Structure structure = must_create(
            world, fragments,
            {.material = {.tensile = 5e5f}, .motion = {.placement = {{0, 1.5f, 0}, {0.9f, 0.3f, 0.1f, 0.3f}}}});
        REQUIRE(world.add_body(ball(0.1f, 20.0f, {0.1f, 1.4f, 3.0f}, {0.0f, 1.0f, -15.0f})).has_value());
        for (int step = 0; step < 150; ++step) {
            world.step();
            if (step == 10) structure.damage(world, {0.4f, 1.5f, 0.0f}, 0.5f, 1.0f);
            structure.update(world);
        }
        CHECK(world.body_count() > 2);
        return world.state_hash();
    };
    check_repeats(play);
}
