// Joints of bonded bodies that break.
#include <algorithm>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "physics/bonds/structure.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

TEST_CASE("a joint of a structure stays with the piece at its anchor when the bar breaks") {
    for (const bool near_end : {true, false}) {
        CAPTURE(near_end);
        World world({.ground_height = std::nullopt, .air_density = 0.0f, .sleeping = false});
        const fracture::Fragments fragments = test::bonded_grid({0.0, 0.0, 0.0}, {0.6, 0.1, 0.1}, 6, 1, 1);
        Result<Structure> made = Structure::create(world, fragments, {.wear = {.enabled = false}});
        REQUIRE(made.has_value());
        Structure& structure = *made;
        REQUIRE(structure.bodies().size() == 1);
        const uint32_t holder = near_end ? 0u : 5u;
        const glm::vec3 anchor(near_end ? 0.02f : 0.58f, 0.05f, 0.05f);
        const Result<JointId> hook = world.add_joint({.a = structure.body_of(0), .anchor_a = anchor});
        REQUIRE(hook.has_value());
        for (int step = 0; step < 30; ++step) world.step(), structure.update(world);
        std::vector<uint32_t> cut;
        for (uint32_t i = 0; i < fragments.bonds.size(); ++i)
            if (std::min(fragments.bonds[i].a, fragments.bonds[i].b) == 2) cut.push_back(i);
        structure.break_bonds(cut);
        structure.update(world);
        REQUIRE(structure.body_of(0) != structure.body_of(5));
        REQUIRE(world.has_joint(*hook));
        CHECK(world.joint(*hook).a.body == structure.body_of(holder));
        CHECK(world.joints_of(structure.body_of(5 - holder)).empty());
        for (int step = 0; step < 60; ++step) world.step(), structure.update(world);
        CHECK(glm::length(world.joint_anchor(*hook, false) - anchor) < 1e-4f);
        CHECK(world.pose(structure.body_of(5 - holder)).position.y < -0.5f); // fell
    }
}

TEST_CASE("a block on a rope that breaks a wall keeps its rope and gives the wall no more momentum than it had") {
    World world({.ground_height = std::nullopt, .air_density = 0.0f, .sleeping = false});
    const fracture::Fragments fragments = test::bonded_grid({-0.5, -0.5, -0.05}, {0.5, 0.5, 0.05}, 8, 8, 1);
    Result<Structure> made = Structure::create(
        world, fragments, {.material = {.tensile = 1e5f, .fracture_energy = 20.0f}, .wear = {.enabled = false}});
    REQUIRE(made.has_value());
    Structure& wall = *made;
    BodyDesc desc = box(glm::vec3(0.15f), 60.0f, {0, 0, -0.5f});
    desc.linear_velocity = {0, 0, 8};
    const BodyId wrecker = must_add(world, desc);
    const Result<JointId> rope = world.add_joint({.kind = JointKind::distance,
                                                  .a = wrecker,
                                                  .anchor_a = {0, 0, -0.5f},
                                                  .anchor_b = {0, 3, -0.5f},
                                                  .max_length = 3.0f});
    REQUIRE(rope.has_value());
    size_t most = 1;
    for (int step = 0; step < 120; ++step) {
        world.step();
        wall.update(world);
        most = std::max(most, wall.bodies().size());
        REQUIRE(glm::length(world.joint_anchor(*rope, false) - world.joint_anchor(*rope, true)) < 3.0f + 0.1f);
    }
    CHECK(most > 5);
    CHECK(world.has_joint(*rope));
    double forward = 0.0;
    for (const BodyId body : wall.bodies()) forward += world.mechanics(body).momentum.z;
    CHECK(forward > 10.0);
    CHECK(forward < 60.0 * 8.0);
}
