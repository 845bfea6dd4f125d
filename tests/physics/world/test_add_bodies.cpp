// World::add_bodies(): many bodies at once equal the same bodies one by one, and a refused batch adds none.
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "physics/world/pieces.h"
#include "physics/world/world.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

constexpr float no_number = std::numeric_limits<float>::quiet_NaN();

// The body rotated and moving, with principal axes of inertia that are not its own axes.
BodyDesc askew(BodyDesc body, test::Random& random) {
    const glm::vec3 axis(random.direction());
    body.pose.orientation = glm::angleAxis(static_cast<float>(random.uniform(0.0, 3.0)), axis);
    body.linear_velocity = glm::vec3(random.point(glm::dvec3(-1.0), glm::dvec3(1.0)));
    body.angular_velocity = glm::vec3(random.point(glm::dvec3(-4.0), glm::dvec3(4.0)));
    const float most = body.inertia[0][0] + body.inertia[1][1] + body.inertia[2][2];
    const glm::mat3 turn = glm::mat3_cast(body.pose.orientation);
    body.inertia = turn * (body.inertia + glm::mat3(most)) * glm::transpose(turn);
    body.friction = static_cast<float>(random.uniform(0.0, 1.0));
    return body;
}

// All kinds of bodies: own and shared hulls, one part off the centre, several parts, fixed and free, with and without a
// known cross section, siblings with the given number and the next (0: none), debris, and bodies with a previous pose.
std::vector<BodyDesc> all_kinds(uint32_t siblings) {
    test::Random random(11);
    const auto shared = std::make_shared<const CollisionHull>(box_hull(glm::vec3(0.05f)));
    std::vector<BodyDesc> bodies;
    for (int i = 0; i < 330; ++i) {
        const glm::vec3 half(
            random.point(glm::dvec3(i % 5 == 0 ? 0.004 : 0.03), glm::dvec3(i % 5 == 0 ? 0.009 : 0.09)));
        const glm::vec3 at(random.point({-1.0, 0.1, -1.0}, {1.0, 2.5, 1.0}));
        BodyDesc body = askew(box(half, static_cast<float>(random.uniform(0.1, 5.0)), at), random);
        if (i % 7 == 1) body.hull.section = {};
        if (i % 11 == 2) body = in_slabs(body, half, 3);
        if (i % 11 == 3) body.hull = {}, body.parts = {{shared, {0.01f, -0.02f, 0.0f}}};
        if (i % 13 == 4) body.fixed = true;
        if (i % 9 == 5) body.previous = Pose{at - 0.1f * body.linear_velocity, {2.0f, 0.1f, 0.0f, 0.0f}};
        if (i % 3 == 0 && siblings > 0) body.siblings = siblings + static_cast<uint32_t>(i % 2);
        bodies.push_back(body);
    }
    return bodies;
}

// The handles, and the state hashes of a run.
struct Story {
    std::vector<BodyId> ids;
    std::vector<uint64_t> hashes;
    friend bool operator==(const Story&, const Story&) = default;
};

// A table falls, `add` adds all kinds of bodies, and some of them are removed at once and later.
Story story(uint32_t threads, const std::function<std::vector<BodyId>(World&, std::span<const BodyDesc>)>& add) {
    World world({.threads = threads});
    must_add(world, box({2.0f, 0.1f, 2.0f}, 10.0f, {0.0f, 0.2f, 0.0f}));
    for (int i = 0; i < 5; ++i) world.step();
    Story told;
    const uint32_t siblings = world.new_siblings();
    (void)world.new_siblings();
    told.ids = add(world, all_kinds(siblings));
    for (const size_t k : {2u, 3u, 27u, 46u}) world.remove_body(told.ids[k]); // 3 and 27 are siblings
    told.hashes.push_back(world.state_hash());
    for (int i = 1; i <= 60; ++i) {
        world.step();
        if (i == 30)
            for (size_t k = 0; k < told.ids.size(); k += 4) world.remove_body(told.ids[k]);
        if (i % 10 == 0) told.hashes.push_back(world.state_hash());
    }
    for (const BodyId id : world.bodies()) told.hashes.push_back(world.last_moved_step(id));
    return told;
}

std::vector<BodyId> one_by_one(World& world, std::span<const BodyDesc> bodies) {
    std::vector<BodyId> ids;
    for (const BodyDesc& body : bodies) ids.push_back(must_add(world, body));
    return ids;
}

std::vector<BodyId> at_once(World& world, std::span<const BodyDesc> bodies) {
    const Result<std::vector<BodyId>> ids = world.add_bodies(bodies);
    REQUIRE_MESSAGE(ids.has_value(), (ids ? std::string() : ids.error().message));
    return *ids;
}

std::vector<BodyId> described(World& world, std::span<const BodyDesc> bodies) {
    const Result<std::vector<BodyId>> ids = world.add_bodies(bodies.size(), [&](size_t i) { return bodies[i]; });
    REQUIRE_MESSAGE(ids.has_value(), (ids ? std::string() : ids.error().message));
    return *ids;
}

// The error of the first body that is refused when they are added one by one.
fracture::Error first_error(World& world, std::span<const BodyDesc> bodies) {
    for (const BodyDesc& body : bodies)
        if (const Result<BodyId> added = world.add_body(body); !added) return added.error();
    FAIL("none was refused");
    return {};
}

} // namespace

TEST_CASE("add bodies: an empty batch changes nothing") {
    World world;
    must_add(world, box(glm::vec3(0.1f), 1.0f, {0.0f, 1.0f, 0.0f}));
    const uint64_t before = world.state_hash();
    CHECK(at_once(world, {}).empty());
    CHECK(described(world, {}).empty());
    CHECK(world.body_count() == 1);
    CHECK(world.state_hash() == before);
}

TEST_CASE("add bodies: a batch equals the same bodies one by one, on any number of threads") {
    const Story expected = story(1, one_by_one);
    REQUIRE(expected.ids.size() == 330);
    CHECK(expected.hashes.front() != expected.hashes.back());
    for (const uint32_t threads : {1u, 2u, 3u, 8u, 0u}) {
        INFO("threads: ", threads);
        CHECK(story(threads, at_once) == expected);
        CHECK(story(threads, described) == expected);
    }
}

TEST_CASE("add bodies: a batch with invalid bodies adds none, and the error is that of the first") {
    const std::vector<std::pair<size_t, std::function<void(BodyDesc&)>>> faults{
        {0, [](BodyDesc& body) { body.mass = -1.0f; }},
        {329, [](BodyDesc& body) { body.pose.position.y = no_number; }},
        {130, [](BodyDesc& body) { body.inertia = glm::mat3(0.0f); }},
        {66, [](BodyDesc& body) { body.hull.points.resize(3), body.parts.clear(); }},
        {66, [](BodyDesc& body) { body.hull.points[5].z = no_number; }},
        {13, [](BodyDesc& body) { body.parts.at(1).hull = nullptr; }}, // a body of three slabs
        {13, [](BodyDesc& body) { body.parts.at(2).offset.x = no_number; }},
        {200, [](BodyDesc& body) { body.restitution = 2.0f; }},
    };
    for (size_t fault = 0; fault < faults.size(); ++fault) {
        INFO("fault: ", fault);
        const auto& [at, spoil] = faults[fault];
        std::vector<BodyDesc> bodies = all_kinds(0);
        spoil(bodies[at]);
        if (at < 300) bodies[at + 20].mass = 0.0f; // a second fault
        World alone;
        const fracture::Error expected = first_error(alone, bodies);
        for (const uint32_t threads : {1u, 2u, 8u}) {
            World world({.threads = threads}), untried({.threads = threads});
            for (World* one : {&world, &untried}) must_add(*one, box(glm::vec3(0.1f), 1.0f, {0.0f, 1.0f, 0.0f}));
            const Result<std::vector<BodyId>> added = world.add_bodies(bodies);
            REQUIRE_FALSE(added.has_value());
            const Result<std::vector<BodyId>> told =
                world.add_bodies(bodies.size(), [&](size_t i) { return bodies[i]; });
            REQUIRE_FALSE(told.has_value());
            CHECK(told.error().message == added.error().message);
            CHECK(added.error().status == expected.status);
            // These worlds hold one body more, so the number in the message is one higher.
            const std::string name = "body " + std::to_string(at), later = "body " + std::to_string(at + 1);
            REQUIRE(expected.message.find(name + " ") == 0);
            CHECK(added.error().message == later + expected.message.substr(name.size()));
            CHECK(world.body_count() == 1);
            for (World* one : {&world, &untried}) {
                CHECK(must_add(*one, box(glm::vec3(0.2f), 1.0f, {0.0f, 2.0f, 0.0f})) == BodyId{1});
                run(*one, 0.5f);
            }
            CHECK(world.state_hash() == untried.state_hash());
        }
    }
}

TEST_CASE(
    "add bodies: pieces with impossible mass properties get those of their bounding box, all others keep their own") {
    fracture::Fragments pieces = test::voronoi_pieces(glm::dvec3(-0.5), glm::dvec3(0.5), 150, 4);
    const std::vector<fracture::Piece> sound = pieces.pieces;
    pieces.pieces[3].mass.volume = -1e-9; // a sliver's volume may round to this
    pieces.pieces[70].mass.volume = 0.0;
    pieces.pieces[71].mass.inertia = glm::dmat3(0.0);
    pieces.pieces[149].mass.inertia[1][1] *= 9.0; // violates the triangle inequality of moments
    const float density = 2000.0f;
    for (const uint32_t threads : {1u, 2u}) {
        World world({.threads = threads});
        const Result<std::vector<BodyId>> bodies = add_pieces(world, pieces, {.density = density});
        REQUIRE(bodies.has_value());
        REQUIRE(bodies->size() == 150);
        for (size_t i = 0; i < 150; ++i) {
            INFO("piece: ", i);
            const bool boxed = i == 3 || i == 70 || i == 71 || i == 149;
            glm::dvec3 low(1.0), high(-1.0);
            for (const glm::dvec3& p : pieces.positions_of(pieces.pieces[i]))
                low = glm::min(low, p), high = glm::max(high, p);
            const glm::dvec3 size = high - low;
            const double volume = boxed ? size.x * size.y * size.z : sound[i].mass.volume;
            CHECK(static_cast<double>(world.mass((*bodies)[i]))
                  == doctest::Approx(density * volume).epsilon(1e-6).scale(0.0));
        }
        run(world, 0.25f);
        CHECK(all_finite(world));
    }
}

TEST_CASE("add bodies: a piece that is invalid even with the mass of a box is named, and no piece is added") {
    fracture::Fragments pieces = test::grid_pieces(glm::dvec3(-0.5), glm::dvec3(0.5), 4, 4, 4);
    pieces.pieces[7].mass.volume = 0.0; // would get the mass of a box
    for (uint32_t v = pieces.pieces[40].vertices.begin; v < pieces.pieces[40].vertices.end; ++v)
        pieces.positions[v] *= 1e7;
    pieces.pieces[40].mass.volume *= 1e21; // heavier than any valid body
    World world;
    const Result<std::vector<BodyId>> bodies = add_pieces(world, pieces);
    REQUIRE_FALSE(bodies.has_value());
    CHECK(bodies.error().status == fracture::Status::invalid_setting);
    CHECK(bodies.error().message.find("piece 40 ") == 0);
    CHECK(bodies.error().message.find("its mass") != std::string::npos);
    CHECK(world.body_count() == 0);
}

TEST_CASE("add bodies: bodies of forms made in advance equal bodies made when they are added") {
    int with_form = 0;
    const auto of_forms = [&](World& world, std::span<const BodyDesc> bodies) {
        std::vector<BodyDesc> ahead(bodies.begin(), bodies.end());
        for (BodyDesc& body : ahead) {
            const auto form = make_form(body);
            REQUIRE(form);
            CHECK((*form == nullptr) == (body.parts.size() > 1));
            if (!*form) continue;
            ++with_form;
            body.form = *form;
            body.hull = {};
            body.parts = {};
            body.mass = no_number; // the form's is used
            body.inertia = glm::mat3(no_number);
            body.fixed = !body.fixed;
        }
        return at_once(world, ahead);
    };
    const Story expected = story(2, at_once);
    CHECK(story(2, of_forms) == expected);
    CHECK(with_form > 200);
}

TEST_CASE("add bodies: a form may be shared, and lives as long as its bodies") {
    std::shared_ptr<const BodyForm> form = *make_form(box(glm::vec3(0.1f), 2.0f, {}));
    World world, one_by_one;
    for (const float x : {-1.0f, 0.0f, 1.0f}) {
        must_add(world, {.form = form, .pose = {{x, 0.5f, 0.0f}, {1.0f, 0.0f, 0.0f, 0.0f}}});
        must_add(one_by_one, box(glm::vec3(0.1f), 2.0f, {x, 0.5f, 0.0f}));
    }
    form.reset();
    for (World* each : {&world, &one_by_one}) each->remove_body(each->bodies()[1]);
    for (int i = 0; i < 120; ++i) world.step(), one_by_one.step();
    CHECK(world.state_hash() == one_by_one.state_hash());
}

TEST_CASE("add bodies: an invalid body has no form, and a form does not make an invalid pose valid") {
    BodyDesc body = box(glm::vec3(0.1f), 2.0f, {});
    const auto form = make_form(body);
    REQUIRE(form);
    for (const auto& spoil : std::vector<std::function<void(BodyDesc&)>>{
             [](BodyDesc& b) { b.mass = 0.0f; }, [](BodyDesc& b) { b.hull.points.resize(3); },
             [](BodyDesc& b) { b.inertia[0][0] = no_number; }, [](BodyDesc& b) { b.inertia = glm::mat3(0.0f); }}) {
        BodyDesc spoilt = body;
        spoil(spoilt);
        CHECK(!make_form(spoilt));
    }
    body.pose.position.x = no_number;
    CHECK(make_form(body));
    World world;
    CHECK(!world.add_body({.form = *form, .pose = body.pose}));
    CHECK(!world.add_body({.form = *form, .friction = -1.0f}));
    CHECK(world.body_count() == 0);
}
