// Structures of several objects: materials, strengths of bonds, hulls and supports of their own.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/pieces/contacts.h"
#include "fracture/shapes/shapes.h"
#include "physics/bonds/assembly.h"
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

// A cube of 0.1 m about its own origin.
const fracture::Fragments& cube() {
    static const fracture::Fragments one = test::grid_pieces(glm::dvec3(-0.05), glm::dvec3(0.05), 1, 1, 1);
    return one;
}

Pose pose_at(const glm::vec3& position, const glm::quat& orientation = {1.0f, 0.0f, 0.0f, 0.0f}) {
    return {position, orientation};
}

AssemblyPart part_at(const fracture::Fragments& fragments, const Pose& placement, StructureDesc desc = {}) {
    desc.motion.placement = placement;
    return {&fragments, desc};
}

// Glue of 0.1 x 0.1 m between the only pieces of two parts.
GlueBond glued(uint32_t a, uint32_t b, const glm::dvec3& centroid, const glm::dvec3& normal, float strength = 1.0f) {
    GlueBond bond{.a = {a, 0}, .area = 0.01, .centroid = centroid, .normal = normal, .strength = strength};
    bond.b = GlueBond::Side{b, 0};
    return bond;
}

Assembly must_assemble(World& world, std::span<const AssemblyPart> parts, std::span<const GlueBond> glue) {
    Result<Assembly> made = assemble(world, parts, glue);
    REQUIRE_MESSAGE(made.has_value(), (made ? std::string() : made.error().message));
    return std::move(*made);
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
    refused({.piece_objects = {0, 1}}, "2 objects were given for 3 pieces");
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

TEST_CASE("glue between pieces that do not exist, of one part, or without area or strength is refused") {
    const std::vector<AssemblyPart> two{part_at(cube(), pose_at({0.0f, 2.0f, 0.0f})),
                                        part_at(cube(), pose_at({0.1f, 2.0f, 0.0f}))};
    const auto refused = [](std::span<const AssemblyPart> parts, std::span<const GlueBond> glue, const char* says) {
        World world;
        const Result<Assembly> made = assemble(world, parts, glue);
        REQUIRE_FALSE(made.has_value());
        CHECK(made.error().status == fracture::Status::invalid_setting);
        CHECK_MESSAGE(made.error().message.find(says) != std::string::npos, made.error().message);
        CHECK(world.body_count() == 0);
    };
    const GlueBond good = glued(0, 1, {0.05, 2.0, 0.0}, {1.0, 0.0, 0.0});
    refused({}, {}, "needs a part");
    const auto bad = [&](const auto& change, const char* says) {
        GlueBond bond = good;
        change(bond);
        refused(two, std::vector{good, bond}, says);
    };
    bad([](GlueBond& bond) { bond.a.part = 2; }, "glue bond 1: there is no part 2, only 2");
    bad([](GlueBond& bond) { bond.b->piece = 1; }, "there is no piece 1 in part 1, only 1");
    bad([](GlueBond& bond) { bond.b->part = 0; }, "both of its sides are of one part");
    bad([](GlueBond& bond) { bond.area = 0.0; }, "area must be positive");
    bad([](GlueBond& bond) { bond.area = std::numeric_limits<double>::quiet_NaN(); }, "area must be positive");
    bad([](GlueBond& bond) { bond.strength = 0.0f; }, "strength must be positive");
    bad([](GlueBond& bond) { bond.strength = std::numeric_limits<float>::infinity(); }, "strength must be positive");
    std::vector<AssemblyPart> faulty = two;
    faulty[1].desc.anchored = {1};
    refused(faulty, std::vector{good}, "part 1: anchored piece 1 does not exist");
    faulty = two;
    faulty[1].desc.piece_parts = {{}};
    refused(faulty, std::vector{good}, "part 1: piece 0 has no hulls");
}

TEST_CASE("an assembly of one part without glue runs as a structure of its own") {
    const fracture::Fragments fragments = row(4);
    const StructureDesc desc{
        .motion = {.placement = pose_at({0.3f, 1.0f, 0.2f}, glm::angleAxis(0.4f, glm::vec3(0, 0, 1)))}};
    const auto run = [&](bool assembled) {
        World world;
        std::optional<Structure> structure;
        if (assembled)
            structure = std::move(must_assemble(world, std::vector<AssemblyPart>{{&fragments, desc}}, {}).structure);
        else
            structure = must_create(world, fragments, desc);
        for (int k = 0; k < 60; ++k) {
            world.step();
            structure->update(world);
        }
        StateHash hash;
        hash.add(world.state_hash());
        hash.add(structure->state_hash());
        return hash.value();
    };
    CHECK(run(true) == run(false));
}

TEST_CASE("two glued cubes, one of them turned, move as the one body that they are") {
    const Pose placement = pose_at({0.7f, 3.0f, -0.4f}, glm::angleAxis(0.8f, glm::normalize(glm::vec3(1, 2, 3))));
    const auto in_world = [&](const glm::dvec3& p) {
        return glm::dvec3(placement.position) + glm::dquat(placement.orientation) * p;
    };
    // The reference: both cubes in one set of fragments, about its first cube's middle.
    fracture::Fragments both = test::bonded_grid({-0.05, -0.05, -0.05}, {0.15, 0.05, 0.05}, 2, 1, 1);
    World reference(test_bodies::empty_space), world(test_bodies::empty_space);
    Structure whole = must_create(reference, both, {.motion = {.placement = placement}});
    const glm::quat quarter = glm::angleAxis(std::numbers::pi_v<float> / 2.0f, glm::vec3(1, 0, 0));
    const std::vector<AssemblyPart> parts{
        part_at(cube(), placement),
        part_at(cube(), pose_at(glm::vec3(in_world({0.1, 0.0, 0.0})), placement.orientation * quarter))};
    Assembly made = must_assemble(world, parts,
                                  std::vector{glued(0, 1, in_world({0.05, 0.0, 0.0}),
                                                    glm::dquat(placement.orientation) * glm::dvec3(1.0, 0.0, 0.0))});
    CHECK(made.first_piece == std::vector<uint32_t>{0, 1, 2});
    CHECK(made.placements[0].turn == glm::dquat(1.0, 0.0, 0.0, 0.0));
    CHECK(glm::length(made.placements[1].to_structure(glm::dvec3(0.0)) - glm::dvec3(0.1, 0.0, 0.0)) < 1e-6);
    CHECK(glm::length(made.placements[1].to_part(made.placements[1].to_structure({1.0, 2.0, 3.0}))
                      - glm::dvec3(1.0, 2.0, 3.0))
          < 1e-12);
    REQUIRE(made.structure.bodies().size() == 1);
    REQUIRE(whole.bodies().size() == 1);
    for (auto [in, structure] : {std::pair(&reference, &whole), std::pair(&world, &made.structure)})
        in->apply_impulse(structure->body_of(0), {0.3f, 2.0f, -1.0f}, glm::vec3(in_world({0.15, 0.05, 0.0})));
    for (int k = 0; k < 120; ++k) {
        reference.step();
        world.step();
        whole.update(reference);
        made.structure.update(world);
    }
    std::vector<glm::vec3> places, of_whole;
    made.structure.visit_poses(world, 1.0f, 0, [&](uint32_t, const Pose& pose) { places.push_back(pose.position); });
    whole.visit_poses(reference, 1.0f, 0, [&](uint32_t, const Pose& pose) { of_whole.push_back(pose.position); });
    REQUIRE(places.size() == 2);
    for (size_t k = 0; k < 2; ++k) CHECK(glm::length(places[k] - of_whole[k]) < 1e-4f);
    CHECK(glm::length(places[0] - glm::vec3(in_world(glm::dvec3(0.0)))) > 0.2f); // it has moved
}

TEST_CASE("the hulls of a turned part are turned") {
    // A beam along x in its own coordinates stands upright on a cube; a ball flies by beside it, or hits it.
    const fracture::Fragments beam = test::grid_pieces({-0.2, -0.05, -0.05}, {0.2, 0.05, 0.05}, 1, 1, 1);
    const glm::quat upright = glm::angleAxis(std::numbers::pi_v<float> / 2.0f, glm::vec3(0, 0, 1));
    for (const bool hits : {true, false}) {
        World world(test_bodies::empty_space);
        const std::vector<AssemblyPart> parts{part_at(cube(), pose_at({0.0f, 1.0f, 0.0f}), {.anchored = {0}}),
                                              part_at(beam, pose_at({0.0f, 1.25f, 0.0f}, upright))};
        Assembly made = must_assemble(world, parts, std::vector{glued(0, 1, {0.0, 1.05, 0.0}, {0.0, 1.0, 0.0}, 1e6f)});
        const BodyId ball = test_bodies::must_add(
            world, {.hull = collision_hull(fracture::icosphere(1, 0.02).positions, glm::dvec3(0.0)),
                    .mass = 0.1f,
                    .inertia = glm::mat3(1e-5f),
                    .pose = {.position = hits ? glm::vec3(0.0f, 1.4f, 0.5f) : glm::vec3(0.15f, 1.25f, 0.5f)},
                    .linear_velocity = {0.0f, 0.0f, -2.0f}});
        for (int k = 0; k < 60; ++k) {
            world.step();
            made.structure.update(world);
        }
        CHECK((world.linear_velocity(ball).z > -1.0f) == hits);
        CHECK((world.pose(ball).position.z > 0.0f) == hits);
    }
}

TEST_CASE(
    "a part that is glued to something fixed hangs while the glue bears its weight, and falls where it does not") {
    const double weight = 2400.0 * 1e-3 * 9.81, area = 0.01; // N, m^2
    const double least = weight / area;                      // Pa
    for (const bool has_material : {false, true})
        for (const double share : {0.8, 1.25}) {
            World world;
            const std::vector<AssemblyPart> parts{
                part_at(cube(), pose_at({0.0f, 2.0f, 0.0f}), {.wear = {.strength_scale = 1.0f}})};
            GlueBond bond{.a = {0, 0}, .area = area, .centroid = {0.0, 2.05, 0.0}, .normal = {0.0, 1.0, 0.0}};
            Material weakest;
            weakest.tensile = static_cast<float>(share * least);
            if (has_material) // the weaker side decides
                bond.fixed_material = weakest;
            else
                bond.strength = weakest.tensile / Material{}.tensile;
            Assembly made = must_assemble(world, parts, std::vector{bond});
            CHECK(made.first_piece == std::vector<uint32_t>{0, 1});
            CHECK(made.structure.piece_count() == 2); // the second one is the support
            REQUIRE(world.body_count() == 1);
            CHECK(world.fixed(made.structure.body_of(0)));
            for (int k = 0; k < 240; ++k) {
                world.step();
                made.structure.update(world);
            }
            CAPTURE(share);
            CHECK((made.structure.graph().live_count() == 1) == (share > 1.0));
            CHECK(world.fixed(made.structure.body_of(0)) == (share > 1.0));
            if (share < 1.0) CHECK(world.pose(made.structure.body_of(0)).position.y < 1.0f);
        }
}

TEST_CASE("momentum is kept where glue breaks, and the parts move apart as one body's points did") {
    World world(test_bodies::empty_space);
    const std::vector<AssemblyPart> parts{
        part_at(cube(), pose_at({0.0f, 0.0f, 0.0f}),
                {.motion = {.linear_velocity = {0.1f, 0.2f, 0.0f}, .angular_velocity = {0.0f, 3.0f, 1.0f}}}),
        part_at(cube(), pose_at({0.1f, 0.0f, 0.0f}, glm::angleAxis(1.1f, glm::vec3(1, 0, 0))))};
    Assembly made = must_assemble(world, parts, std::vector{glued(0, 1, {0.05, 0.0, 0.0}, {1.0, 0.0, 0.0})});
    REQUIRE(world.body_count() == 1);
    for (int k = 0; k < 10; ++k) {
        world.step();
        made.structure.update(world);
    }
    const Mechanics before = world.mechanics();
    made.structure.break_bonds(std::vector<uint32_t>{0});
    made.structure.update(world);
    REQUIRE(world.body_count() == 2);
    const Mechanics after = world.mechanics();
    CHECK(glm::length(after.momentum - before.momentum) < 1e-5);
    CHECK(glm::length(after.angular_momentum - before.angular_momentum) < 1e-5);
    CHECK(after.kinetic == doctest::Approx(before.kinetic).epsilon(1e-4));
    CHECK(glm::length(before.momentum) > 0.5);
    const float apart =
        glm::distance(world.pose(made.structure.body_of(0)).position, world.pose(made.structure.body_of(1)).position);
    for (int k = 0; k < 60; ++k) {
        world.step();
        made.structure.update(world);
    }
    CHECK(glm::distance(world.pose(made.structure.body_of(0)).position, world.pose(made.structure.body_of(1)).position)
          > apart + 0.05f);
}

TEST_CASE("pieces that are removed leave the rest of their body in motion, in one part or in two") {
    World world(test_bodies::empty_space);
    fracture::Fragments fragments = row(5);
    Structure structure = must_create(world, fragments, {.motion = {.linear_velocity = {0.0f, 1.0f, 0.0f}}});
    structure.remove_pieces(world, {});
    CHECK(world.body_count() == 1);
    structure.remove_pieces(world, std::vector<uint32_t>{2, 2});
    CHECK(structure.body_of(2) == BodyId{});
    REQUIRE(world.body_count() == 2);
    CHECK(structure.body_of(0) == structure.body_of(1));
    CHECK(structure.body_of(3) == structure.body_of(4));
    for (const BodyId body : world.bodies()) CHECK(world.linear_velocity(body).y == doctest::Approx(1.0f));
    world.step();
    structure.update(world);
    CHECK(world.body_count() == 2);
    structure.remove_pieces(world, std::vector<uint32_t>{0, 1, 3});
    CHECK(world.body_count() == 1);
    CHECK(structure.pieces_of_body(4).size() == 1);
}

TEST_CASE("a part that comes off as a whole is not detached, and half of it is") {
    World world(test_bodies::empty_space);
    const fracture::Fragments two = test::bonded_grid({-0.1, -0.05, -0.05}, {0.1, 0.05, 0.05}, 2, 1, 1), ten = row(10);
    const std::vector<AssemblyPart> parts{part_at(ten, {}), part_at(two, pose_at({1.1f, 2.05f, 0.05f}))};
    GlueBond glue{.a = {0, 9}, .area = 0.01, .centroid = {1.0, 2.05, 0.05}, .normal = {1.0, 0.0, 0.0}};
    glue.b = GlueBond::Side{1, 0};
    Assembly made = must_assemble(world, parts, std::vector{glue});
    Structure& structure = made.structure;
    REQUIRE(world.body_count() == 1);
    for (const uint32_t piece : {0u, 9u, 10u, 11u}) CHECK_FALSE(structure.is_detached(piece));
    const auto bond_between = [&](uint32_t a, uint32_t b) {
        const auto bonds = structure.graph().bonds();
        const auto at = std::ranges::find_if(bonds, [&](const auto& bond) { return bond.a == a && bond.b == b; });
        REQUIRE(at != bonds.end());
        return std::vector{static_cast<uint32_t>(at - bonds.begin())};
    };
    structure.break_bonds(bond_between(9, 10));
    structure.update(world);
    REQUIRE(world.body_count() == 2);
    for (const uint32_t piece : {0u, 9u, 10u, 11u}) CHECK_FALSE(structure.is_detached(piece));
    structure.break_bonds(bond_between(10, 11));
    structure.break_bonds(bond_between(4, 5));
    structure.update(world);
    REQUIRE(world.body_count() == 4);
    for (const uint32_t piece : {0u, 9u, 10u, 11u}) CHECK(structure.is_detached(piece));
}
