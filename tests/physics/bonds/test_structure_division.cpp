// Structure::divide(): pieces that go on as their parts.
#include <cmath>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "physics/bonds/structure.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

// The cells of a grid of boxes as parts.
std::vector<Structure::Part> parts_of(const fracture::Fragments& cells, const Material& material = {}) {
    std::vector<Structure::Part> parts;
    const PieceHulls hulls = collision_hulls(cells);
    for (const fracture::Piece& cell : cells.pieces)
        parts.push_back({.centre = cell.mass.centre_of_mass,
                         .mass = true_mass(cell, static_cast<double>(material.density)),
                         .hulls = {{hulls[parts.size()]}},
                         .material = material});
    return parts;
}

// A bar of cubes of 0.1 m along x.
fracture::Fragments bar(int count) {
    return test::bonded_grid({0.0, 0.0, 0.0}, {0.1 * count, 0.1, 0.1}, count, 1, 1);
}

Structure must_create(World& world, const fracture::Fragments& fragments, const StructureDesc& desc = {}) {
    Result<Structure> structure = Structure::create(world, fragments, desc);
    REQUIRE_MESSAGE(structure.has_value(), (structure ? std::string() : structure.error().message));
    return std::move(*structure);
}

double off(const glm::dvec3& now, const glm::dvec3& before) {
    return glm::length(now - before) / glm::length(before);
}

} // namespace

TEST_CASE("a divided piece leaves its body in motion: parts at the contacts stay, what lies between comes off") {
    World world(empty_space);
    const PlacedMotion motion{.placement = {{1.0f, 0.5f, 0.0f}, glm::angleAxis(0.7f, glm::vec3(0.0f, 1.0f, 0.0f))},
                              .linear_velocity = {0.5f, 0.0f, 0.0f},
                              .angular_velocity = {0.0f, 3.0f, 1.0f}};
    Structure structure = must_create(world, bar(3), {.motion = motion});
    for (int step = 0; step < 30; ++step) world.step(), structure.update(world);
    const Mechanics before = world.mechanics();
    const BodyId whole = structure.body_of(1);
    const glm::vec3 left = world.pose(whole).position + world.pose(whole).orientation * structure.offset(0);
    // Three slices across the bar.
    REQUIRE(structure.divide(world, 1, parts_of(test::bonded_grid({0.1, 0.0, 0.0}, {0.2, 0.1, 0.1}, 3, 1, 1))));
    REQUIRE(structure.piece_count() == 6);
    CHECK_FALSE(world.contains(whole));
    CHECK(structure.body_of(1) == BodyId{});
    CHECK(structure.pieces_of_body(1).empty());
    CHECK(world.body_count() == 3);
    CHECK(structure.body_of(3) == structure.body_of(0));
    CHECK(structure.body_of(5) == structure.body_of(2));
    CHECK(structure.pieces_of_body(4).size() == 1);
    const Mechanics after = world.mechanics();
    CHECK(off(after.momentum, before.momentum) < 1e-5);
    CHECK(off(after.angular_momentum, before.angular_momentum) < 1e-4);
    CHECK(after.kinetic == doctest::Approx(before.kinetic).epsilon(1e-4));
    const BodyId half = structure.body_of(0);
    CHECK(glm::length(world.pose(half).position + world.pose(half).orientation * structure.offset(0) - left) < 1e-5f);
    CHECK(structure.graph().live_count() == 2);
    CHECK(structure.update(world).broken.empty()); // the bonds went on to the parts
    // Parts of parts.
    REQUIRE(structure.divide(world, 3, parts_of(test::bonded_grid({0.1, 0.0, 0.0}, {0.4 / 3, 0.1, 0.1}, 1, 2, 2))));
    CHECK(structure.graph().live_count() == 5);
    CHECK(structure.pieces_of_body(0).size() == 5);
    CHECK(world.body_count() == 3);
    for (int step = 0; step < 30; ++step) world.step(), structure.update(world);
    CHECK(off(world.mechanics().momentum, before.momentum) < 1e-4);
    CHECK_FALSE(structure.divide(world, 1, parts_of(bar(1)))); // gone
    std::vector<Structure::Part> dust = parts_of(bar(1));
    dust[0].mass.mass = 1e-30;
    CHECK_FALSE(structure.divide(world, 0, dust));
    CHECK(structure.piece_count() == 10);
    CHECK(world.body_count() == 3);
}

TEST_CASE("a column of which one block is divided lengthwise stands and carries its load by both parts") {
    World world({.sleeping = false});
    const fracture::Fragments column = test::bonded_grid({0.0, 0.0, 0.0}, {0.1, 0.4, 0.1}, 1, 4, 1);
    Material material;
    StructureDesc desc{.material = material, .anchored = {0}};
    Structure structure = must_create(world, column, desc);
    for (int step = 0; step < 120; ++step) world.step(), structure.update(world);
    REQUIRE(structure.wear().solver().converged());
    const double whole = std::abs(structure.wear().solver().load(1).force.y); // above the second block
    REQUIRE(structure.divide(world, 1, parts_of(test::bonded_grid({0.0, 0.1, 0.0}, {0.1, 0.2, 0.1}, 2, 1, 1))));
    CHECK(world.body_count() == 1);
    for (int step = 0; step < 240; ++step) {
        world.step();
        REQUIRE(structure.update(world).broken.empty());
    }
    REQUIRE(structure.wear().solver().converged());
    double carried = 0.0;
    size_t bonds = 0;
    const auto all = structure.graph().bonds();
    for (uint32_t k = 0; k < all.size(); ++k) {
        if (all[k].other(2) < 4 || (all[k].a != 2 && all[k].b != 2)) continue;
        ++bonds;
        CHECK(structure.wear().ratios()[k] > 0.0);
        carried += std::abs(structure.wear().solver().load(k).force.y);
    }
    CHECK(bonds == 2);
    CHECK(carried == doctest::Approx(whole).epsilon(0.02));
    // Once one part is gone the other carries all; once both are, what stood on them falls.
    structure.isolate(4);
    world.step(), structure.update(world);
    CHECK(structure.body_of(3) == structure.body_of(0));
    structure.isolate(5);
    world.step(), structure.update(world);
    CHECK(structure.body_of(3) != structure.body_of(0));
    CHECK_FALSE(world.fixed(structure.body_of(3)));
}

TEST_CASE("parts are anchored where the piece was, and parts of one piece count as one") {
    World world(empty_space);
    Structure structure = must_create(world, bar(4), {.anchored = {0}});
    std::vector<Structure::Part> ends = parts_of(test::bonded_grid({0.0, 0.0, 0.0}, {0.1, 0.1, 0.1}, 2, 1, 1));
    ends[0].anchored = true;
    REQUIRE(structure.divide(world, 0, ends));
    CHECK(structure.anchored(4));
    CHECK(world.fixed(structure.body_of(4)));
    CHECK_FALSE(structure.anchored(5));
    CHECK_FALSE(world.fixed(structure.body_of(5)));
    CHECK(structure.body_of(5) == structure.body_of(3));
    std::vector<Structure::Part> middle = parts_of(test::bonded_grid({0.1, 0.0, 0.0}, {0.2, 0.1, 0.1}, 1, 2, 2));
    for (Structure::Part& part : middle) part.anchored = true; // the piece was not
    REQUIRE(structure.divide(world, 1, middle));
    CHECK_FALSE(world.fixed(structure.body_of(3)));
    CHECK(structure.pieces_of_body(3).size() == 7); // half a block, a block in four, and two blocks
    CHECK_FALSE(structure.is_detached(3));          // three and a half of four
    structure.isolate(2);
    structure.update(world);
    CHECK(structure.pieces_of_body(5).size() == 5);
    CHECK(structure.is_detached(5)); // one and a half
    CHECK(structure.is_detached(2));
}

TEST_CASE("a joint of a divided piece goes on with the part at its anchor, also one that comes off") {
    World world({.ground_height = std::nullopt, .air_density = 0.0f, .sleeping = false});
    Structure structure = must_create(world, bar(3), {.wear = {.enabled = false}});
    const glm::vec3 anchor(0.15f, 0.09f, 0.05f);
    const Result<JointId> hook = world.add_joint({.a = structure.body_of(1), .anchor_a = anchor});
    REQUIRE(hook.has_value());
    REQUIRE(structure.divide(world, 1, parts_of(test::bonded_grid({0.1, 0.0, 0.0}, {0.2, 0.1, 0.1}, 3, 1, 1))));
    REQUIRE(world.has_joint(*hook));
    CHECK(world.joint(*hook).a.body == structure.body_of(4));
    for (int step = 0; step < 60; ++step) world.step(), structure.update(world);
    CHECK(world.pose(structure.body_of(4)).position.y > -0.1f); // hangs
    CHECK(world.pose(structure.body_of(0)).position.y < -0.5f);
}
