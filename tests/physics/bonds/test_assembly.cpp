// Structures of several objects: materials, strengths of bonds, hulls and supports of their own.
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "fracture/pieces/contacts.h"
#include "fracture/shapes/shapes.h"
#include "physics/bonds/structure.h"
#include "physics/world/hull.h"
#include "physics/world/state_hash.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

Structure must_create(World& world, const fracture::Fragments& fragments, const StructureDesc& desc) {
    Result<Structure> structure = Structure::create(world, fragments, desc);
    REQUIRE_MESSAGE(structure.has_value(), (structure ? std::string() : structure.error().message));
    return std::move(*structure);
}

// Cubes of 0.1 m along x, with the bonds that find_contacts() gives.
fracture::Fragments row(int count) {
    fracture::Fragments fragments = test::grid_pieces({0.0, 2.0, 0.0}, {0.1 * count, 2.1, 0.1}, count, 1, 1);
    auto bonds = fracture::find_contacts(fragments);
    REQUIRE(bonds);
    fragments.bonds = std::move(*bonds);
    REQUIRE(fragments.bonds.size() == static_cast<size_t>(count - 1));
    return fragments;
}

// One cube of 0.1 m below a support at its upper face.
fracture::Fragments hanging() {
    fracture::Fragments fragments = test::grid_pieces({0.0, 2.0, 0.0}, {0.1, 2.2, 0.1}, 1, 2, 1);
    auto bonds = fracture::find_contacts(fragments);
    REQUIRE(bonds);
    fragments.bonds = std::move(*bonds);
    REQUIRE(fragments.bonds.size() == 1);
    return fragments;
}

std::vector<std::vector<BodyPart>> single_parts(const fracture::Fragments& fragments) {
    std::vector<std::vector<BodyPart>> parts;
    for (const auto& hull : collision_hulls(fragments)) parts.push_back({{hull}});
    return parts;
}

} // namespace

TEST_CASE("an assembly with lists of the wrong length, bad strengths or missing hulls is refused") {
    const fracture::Fragments three = row(3);
    const auto refused = [&](const StructureDesc& desc, const char* says) {
        World world;
        const Result<Structure> made = Structure::create(world, three, desc);
        REQUIRE_FALSE(made.has_value());
        CHECK(made.error().status == fracture::Status::invalid_setting);
        CHECK_MESSAGE(made.error().message.find(says) != std::string::npos, made.error().message);
        CHECK(world.body_count() == 0);
    };
    refused({.piece_materials = std::vector<Material>(2)}, "2 materials were given for 3 pieces");
    refused({.piece_materials = {Material{}, Material{}, Material{.density = -1.0f}}}, "piece 2");
    refused({.bond_strength = {1e5f}}, "1 strengths were given for 2 bonds");
    refused({.bond_strength = {1e5f, -1.0f}}, "strength of bond 1");
    refused({.bond_strength = {std::numeric_limits<float>::quiet_NaN(), 1.0f}}, "strength of bond 0");
    refused({.bond_strength = {1.0f, std::numeric_limits<float>::infinity()}}, "strength of bond 1");
    refused({.piece_parts = std::vector<std::vector<BodyPart>>(1)}, "1 lists of hulls");
    refused({.piece_parts = std::vector<std::vector<BodyPart>>(3)}, "piece 0 has no hulls");
    refused({.piece_parts = std::vector<std::vector<BodyPart>>(3, std::vector<BodyPart>(1))}, "is missing");
    refused({.hulls = collision_hulls(three), .piece_parts = single_parts(three)}, "leave one of them out");
    refused({.supports = {3}}, "support 3 does not exist");
}

TEST_CASE("a structure whose pieces and bonds are all alike runs as one without lists") {
    const auto run = [](const StructureDesc& desc) {
        World world;
        const fracture::Fragments fragments = row(6);
        Structure structure = must_create(world, fragments, desc);
        REQUIRE(world.add_body({.hull = collision_hull(fracture::icosphere(1, 0.1).positions, glm::dvec3(0.0)),
                                .mass = 8.0f,
                                .inertia = glm::mat3(0.03f),
                                .pose = {.position = {0.31f, 2.05f, 1.0f}},
                                .linear_velocity = {0.0f, 0.0f, -15.0f}}));
        for (int k = 0; k < 120; ++k) {
            world.step();
            structure.update(world);
        }
        CHECK(structure.graph().live_count() < 5);
        StateHash hash;
        hash.add(world.state_hash());
        hash.add(structure.state_hash());
        return hash.value();
    };
    const fracture::Fragments fragments = row(6);
    const uint64_t plain = run({.anchored = {0}});
    CHECK(run({.anchored = {0}, .piece_materials = std::vector<Material>(6)}) == plain);
    CHECK(run({.anchored = {0}, .bond_strength = std::vector<float>(5, 0.0f)}) == plain);
    CHECK(run({.anchored = {0}, .bond_strength = std::vector<float>(5, Material{}.tensile)}) == plain);
    CHECK(run({.anchored = {0}, .piece_parts = single_parts(fragments)}) == plain);
}

TEST_CASE("a piece that is glued to a support hangs while the glue bears its weight, and falls where it does not") {
    const fracture::Fragments fragments = hanging();
    const double weight = 2400.0 * 1e-3 * 9.81, area = 0.01; // N, m^2
    const double least = weight / area;                      // Pa in the glue, uniform: the weight hangs in the middle
    for (const double share : {0.8, 1.25}) {
        World world;
        Structure structure = must_create(
            world, fragments,
            {.wear = {.strength_scale = 1.0f}, .bond_strength = {static_cast<float>(share * least)}, .supports = {1}});
        REQUIRE(world.body_count() == 1); // the support has none
        CHECK(world.fixed(structure.body_of(0)));
        size_t seen = 0;
        structure.visit_poses(world, 1.0f, 0, [&](uint32_t piece, const Pose&) {
            CHECK(piece == 0);
            ++seen;
        });
        CHECK(seen == 1);
        for (int k = 0; k < 240; ++k) {
            world.step();
            structure.update(world);
        }
        CAPTURE(share);
        CHECK(world.body_count() == 1);
        CHECK((structure.graph().live_count() == 1) == (share > 1.0));
        CHECK(world.fixed(structure.body_of(0)) == (share > 1.0));
        if (share < 1.0) CHECK(world.pose(structure.body_of(0)).position.y < 1.0f);
        CHECK(structure.body_of(1) == (share > 1.0 ? structure.body_of(0) : BodyId{}));
    }
}

TEST_CASE("a released support lets its piece fall") {
    World world;
    Structure structure = must_create(world, hanging(), {.supports = {1}});
    const std::vector<uint32_t> support{1};
    structure.release_anchors(support);
    for (int k = 0; k < 60; ++k) {
        structure.update(world);
        world.step();
    }
    CHECK_FALSE(world.fixed(structure.body_of(0)));
    CHECK(world.pose(structure.body_of(0)).position.y < 1.5f);
}

TEST_CASE("pieces have the masses of their materials, and a bond the strength of the weaker one or of its glue") {
    World world({.gravity = glm::vec3(0.0f)});
    Material light, heavy;
    light.density = 600.0f;
    light.tensile = 2e6f;
    heavy.density = 7800.0f;
    heavy.tensile = 9e6f;
    const Structure structure =
        must_create(world, row(3), {.piece_materials = {heavy, light, heavy}, .bond_strength = {0.0f, 5e5f}});
    REQUIRE(structure.bodies().size() == 1);
    const BodyId body = structure.body_of(0);
    // 0.1 m cubes of 7.8, 0.6 and 7.8 kg: a push through the middle of the row moves 16.2 kg.
    world.apply_impulse(body, {0.0f, 16.2f, 0.0f}, world.pose(body).position);
    CHECK(world.linear_velocity(body).y == doctest::Approx(1.0).epsilon(1e-5));
    const BondGraph& graph = structure.graph();
    const auto tensile = [&](uint32_t bond) {
        return graph.impulse_strength(graph.bonds()[bond], graph.bonds()[bond].a, -graph.bonds()[bond].normal)
               / (static_cast<double>(impact_seconds) * graph.bonds()[bond].area * graph.bonds()[bond].lever
                  * graph.bonds()[bond].share);
    };
    CHECK(tensile(0) == doctest::Approx(2e6).epsilon(1e-6));
    CHECK(tensile(1) == doctest::Approx(5e5).epsilon(1e-6));
}

TEST_CASE("a contact with any hull of a piece is a contact with that piece") {
    const fracture::Fragments fragments = row(2);
    std::vector<std::vector<BodyPart>> parts = single_parts(fragments);
    // The first piece has hulls far along -x, too: the second one has the fourth hull of the body.
    for (const float x : {-0.2f, -0.4f}) parts[0].push_back({parts[0][0].hull, {x, 0.0f, 0.0f}});
    for (const bool first : {true, false}) {
        World world;
        Structure structure = must_create(world, fragments, {.anchored = {0, 1}, .piece_parts = parts});
        const float x = first ? -0.35f : 0.15f;
        REQUIRE(world.add_body({.hull = collision_hull(fracture::icosphere(1, 0.04).positions, glm::dvec3(0.0)),
                                .mass = 100.0f,
                                .inertia = glm::mat3(0.1f),
                                .pose = {.position = {x, 2.05f, 0.5f}},
                                .linear_velocity = {0.0f, 0.0f, -60.0f}}));
        std::vector<uint32_t> hit;
        for (int k = 0; k < 6; ++k) {
            world.step();
            for (const Impact& impact : structure.update(world).impacts) hit.push_back(impact.piece);
        }
        REQUIRE_FALSE(hit.empty());
        for (const uint32_t piece : hit) CHECK(piece == (first ? 0u : 1u));
    }
}
