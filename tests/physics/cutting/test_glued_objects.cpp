// Glued objects of a Destruction: common structures, turned objects, cuts of their pieces, and their removal.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "physics/cutting/destruction.h"
#include "tests/physics/bodies.h"
#include "tests/physics/destruction_fixture.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;
using namespace brittle::physics::test_destruction;

namespace {

// A bar of five cubes of 0.2 m along x from the origin, with bonds.
const fracture::Fragments& bar() {
    static const fracture::Fragments five = [] {
        fracture::TriangleMesh mesh = fracture::cuboid({1.0, 0.2, 0.2});
        for (glm::dvec3& p : mesh.positions) p.x += 0.5;
        std::vector<glm::dvec3> sites;
        for (int k = 0; k < 5; ++k) sites.push_back({0.1 + 0.2 * k, 0.0, 0.0});
        return *fracture::fracture(mesh, sites);
    }();
    return five;
}

// A bar along x, and one along y that is glued to its end: an L in the plane z = 1.
struct Angle {
    World world;
    Destruction destruction;
    std::vector<ObjectId> objects;
    Pose places[2] = {{{0.0f, 1.0f, 1.0f}, {1.0f, 0.0f, 0.0f, 0.0f}},
                      {{0.9f, 1.1f, 1.0f}, glm::angleAxis(std::numbers::pi_v<float> / 2.0f, glm::vec3(0, 0, 1))}};

    explicit Angle(const WorldSettings& settings = empty_space, const StructureDesc& first = {}) : world(settings) {
        const BreakableDesc pieces = desc_of(0.03);
        const auto solids = solids_of(bar(), pieces.solid, false, 1);
        REQUIRE(solids.has_value());
        std::vector<AssemblyPart> parts;
        for (const Pose& place : places) {
            AssemblyPart& part = parts.emplace_back(AssemblyPart{&bar(), first});
            if (parts.size() == 2) part.desc.anchored = {};
            part.desc.material = weak;
            part.desc.motion.placement = place;
            for (const SolidPtr& solid : *solids) part.desc.piece_parts.push_back(solid->parts);
        }
        GlueBond glue{.a = {0, 4}, .area = 0.04, .centroid = {0.9, 1.1, 1.0}, .normal = {0.0, 1.0, 0.0}};
        glue.b = GlueBond::Side{1, 0};
        const Result<AssemblyId> glued = destruction.assemble(world, parts, std::vector{glue});
        REQUIRE_MESSAGE(glued.has_value(), (glued ? std::string() : glued.error().message));
        for (uint32_t part = 0; part < 2; ++part) {
            BreakableDesc desc = pieces;
            desc.motion.placement = places[part];
            objects.push_back(destruction.add(world, *glued, part, desc, *solids));
        }
    }
    // The pieces of an object.
    [[nodiscard]] std::vector<PieceId> pieces(size_t object) const {
        std::vector<PieceId> own = destruction.pieces();
        std::erase_if(own, [&](PieceId id) { return destruction.object(id) != objects[object]; });
        return own;
    }
};

} // namespace

TEST_CASE("glued objects share one structure and body, and each piece has the pose of its object") {
    Angle angle;
    CHECK(angle.world.body_count() == 1);
    CHECK(angle.destruction.structures().size() == 1);
    CHECK(angle.destruction.structure(angle.objects[0]) == angle.destruction.structure(angle.objects[1]));
    CHECK(angle.destruction.structure(angle.objects[0])->graph().live_count() == 4 + 4 + 1);
    std::map<uint32_t, Pose> by_slot;
    angle.destruction.visit_poses(angle.world, 1.0f, 0, [&](uint32_t slot, const Pose& pose) { by_slot[slot] = pose; });
    REQUIRE(by_slot.size() == 10);
    for (size_t object = 0; object < 2; ++object) {
        const std::vector<PieceId> pieces = angle.pieces(object);
        REQUIRE(pieces.size() == 5);
        for (size_t k = 0; k < 5; ++k) {
            CHECK(pieces[k].value == 5 * object + k); // numbered object by object
            CHECK(angle.destruction.bonded(pieces[k]) == std::optional(static_cast<uint32_t>(5 * object + k)));
            const Pose& place = angle.places[object];
            const glm::vec3 centre =
                place.position + place.orientation * glm::vec3(bar().pieces[k].mass.centre_of_mass);
            for (const Pose& pose :
                 {by_slot.at(angle.destruction.slot(pieces[k])), angle.destruction.pose(angle.world, pieces[k])}) {
                CHECK(glm::length(pose.position - centre) < 1e-5f);
                CHECK(std::abs(glm::dot(pose.orientation, place.orientation)) == doctest::Approx(1.0f));
            }
        }
    }
}

TEST_CASE("a cut of a piece of a turned object leaves its parts where the piece was, and momentum as it was") {
    Angle angle;
    World& world = angle.world;
    Destruction& destruction = angle.destruction;
    const BodyId body = destruction.body(angle.pieces(0)[0]);
    world.set_velocity(body, {0.5f, -0.2f, 0.1f}, {0.0f, 0.4f, 1.5f});
    run(world, destruction, 5);
    const PieceId struck = angle.pieces(1)[2];
    const glm::vec3 centre = destruction.pose(world, struck).position;
    const Mechanics before = world.mechanics();
    const glm::vec3 side = destruction.pose(world, struck).orientation * glm::vec3(0.0f, 0.0f, 1.0f);
    REQUIRE(destruction.strike(world, struck, centre + 0.1f * side, -side, 500.0));
    int steps = 0;
    while (destruction.contains(struck) && ++steps < 20) run(world, destruction, 1);
    REQUIRE_FALSE(destruction.contains(struck));
    const Mechanics after = world.mechanics();
    CHECK(glm::length(after.momentum - before.momentum) < 1e-3 * glm::length(before.momentum));
    CHECK(glm::length(after.angular_momentum - before.angular_momentum) < 1e-3 * glm::length(before.angular_momentum));
    // A bonded neighbour of the same object tells where the object's coordinates are now.
    const PieceId neighbour = angle.pieces(1)[2]; // behind the one that is gone
    REQUIRE(destruction.bonded(neighbour) == std::optional(8u));
    const Pose there = destruction.pose(world, neighbour);
    const glm::dquat turn(there.orientation);
    const glm::dvec3 origin = glm::dvec3(there.position) - turn * bar().pieces[3].mass.centre_of_mass;
    double volume = 0.0;
    size_t parts = 0;
    for (const PieceId id : angle.pieces(1)) {
        if (destruction.depth(id) == 0) continue;
        ++parts;
        const SolidPiece& solid = *destruction.solid(id);
        const Pose pose = destruction.pose(world, id);
        volume += solid.mass.volume;
        CHECK(std::abs(glm::dot(pose.orientation, there.orientation)) > 0.99f);
        const glm::dvec3 expected = origin + turn * solid.mass.centre_of_mass;
        CHECK(glm::length(glm::dvec3(pose.position) - expected) < 0.03); // at most some steps apart
        CHECK(std::abs(solid.mass.centre_of_mass.x - 0.5) < 0.1);
    }
    REQUIRE(parts >= 2);
    CHECK(volume == doctest::Approx(0.008).epsilon(1e-6));
    CHECK(destruction.structures().size() == 1);
    // The parts that touch a neighbour hold on to it: the contacts are as large as before.
    double area = 0.0;
    for (const BondGraph::Bond& bond : destruction.structure(angle.objects[0])->graph().bonds())
        if (bond.live()) area += bond.area;
    CHECK(area == doctest::Approx((4 + 4 + 1) * 0.04).epsilon(1e-9));
}

TEST_CASE("an object that is removed leaves what was glued to it in motion") {
    Angle angle;
    angle.world.set_velocity(angle.destruction.body(angle.pieces(0)[0]), {0.0f, 1.0f, 0.0f}, glm::vec3(0.0f));
    run(angle.world, angle.destruction, 1);
    angle.destruction.remove(angle.world, angle.objects[0]);
    CHECK(angle.pieces(0).empty());
    REQUIRE(angle.pieces(1).size() == 5);
    CHECK(angle.world.body_count() == 1);
    CHECK(angle.destruction.structure(angle.objects[0]) == nullptr);
    REQUIRE(angle.destruction.structure(angle.objects[1]));
    run(angle.world, angle.destruction, 5);
    CHECK(angle.world.linear_velocity(angle.destruction.body(angle.pieces(1)[0])).y == doctest::Approx(1.0f));
    CHECK(angle.pieces(1).size() == 5);
    angle.destruction.remove(angle.world, angle.objects[1]);
    CHECK(angle.world.body_count() == 0);
    CHECK(angle.destruction.structures().empty());
}

TEST_CASE("a blow on glued objects gives the same state with any number of threads" * doctest::test_suite("long")) {
    const auto play = [](uint32_t threads) {
        WorldSettings settings = empty_space;
        settings.threads = threads;
        Angle angle(settings);
        run(angle.world, angle.destruction, 1);
        shoot(angle.world, 0.1f, 20.0f, {0.9f, 1.5f, 4.0f}, {0.0f, 0.0f, -20.0f});
        const PieceId struck = angle.pieces(1)[2];
        const glm::vec3 front = angle.destruction.pose(angle.world, struck).position + glm::vec3(0.0f, 0.0f, 0.1f);
        REQUIRE(angle.destruction.strike(angle.world, struck, front, {0.0f, 0.0f, -1.0f}, 500.0));
        run(angle.world, angle.destruction, 120);
        CHECK(angle.destruction.pieces().size() > 10);
        return std::pair(angle.world.state_hash(), angle.destruction.state_hash());
    };
    const auto one = play(1);
    CHECK(play(2) == one);
    CHECK(play(7) == one);
}
