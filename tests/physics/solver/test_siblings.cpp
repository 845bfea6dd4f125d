// Siblings, the pieces of one cut: skipping their pairs while they fly as one changes no result.
#include <algorithm>
#include <optional>
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

// A row of touching boxes, a metre above the ground.
std::vector<BodyDesc> row_of_boxes(int count) {
    std::vector<BodyDesc> row;
    for (int i = 0; i < count; ++i)
        row.push_back(box({0.1f, 0.1f, 0.1f}, 2.0f, {0.2f * static_cast<float>(i), 1.0f, 0.0f}));
    return row;
}

// The state one second after the bodies were added, as siblings or not.
struct Outcome {
    uint64_t hash;
    float widest = 0.0f; // m, distance of the first body from the last
};
Outcome after_a_second(std::vector<BodyDesc> bodies, bool siblings, const WorldSettings& settings = {}) {
    World world(settings);
    const uint32_t number = world.new_siblings();
    for (BodyDesc& body : bodies) {
        body.siblings = siblings ? number : 0;
        must_add(world, body);
    }
    run(world, 1.0f);
    const auto ids = world.bodies();
    return {world.state_hash(), glm::length(world.pose(ids.front()).position - world.pose(ids.back()).position)};
}

} // namespace

TEST_CASE("siblings: thrown pieces of one cut fly as the whole would, without contacts") {
    const auto fragments = test::voronoi_pieces(glm::dvec3(-0.25), glm::dvec3(0.25), 60, 5);
    World world({.ground_height = std::nullopt, .air_density = 0.0f});
    const glm::vec3 speed(1.0f, 4.0f, -2.0f);
    const auto bodies = add_pieces(world, fragments, {}, {.linear_velocity = speed});
    REQUIRE(bodies.has_value());
    constexpr int steps = 60;
    for (int i = 0; i < steps; ++i) {
        world.step();
        CHECK(world.contacts().empty());
    }
    // A free body follows its parabola.
    const double seconds = steps * static_cast<double>(world.settings().step);
    const glm::dvec3 way = glm::dvec3(speed) * seconds + glm::dvec3(0.0, -9.81, 0.0) * (0.5 * seconds * seconds);
    for (size_t i = 0; i < bodies->size(); ++i) {
        const glm::dvec3 flown =
            glm::dvec3(world.pose((*bodies)[i]).position) - fragments.pieces[i].mass.centre_of_mass;
        CHECK(glm::length(flown - way) < 1e-5);
    }
}

TEST_CASE("siblings: pieces that move into each other collide as other bodies do") {
    // The outer ones close in on the middle.
    std::vector<BodyDesc> row = row_of_boxes(3);
    row.front().linear_velocity = {1.5f, 0.0f, 0.0f};
    row.back().linear_velocity = {-1.5f, 0.0f, 0.0f};
    const Outcome strangers = after_a_second(row, false), siblings = after_a_second(row, true);
    CHECK(siblings.hash == strangers.hash);
    CHECK(siblings.widest > 0.39f);
}

TEST_CASE("siblings: pieces that rotate against each other collide as other bodies do") {
    std::vector<BodyDesc> row = row_of_boxes(2);
    row.back().angular_velocity = {0.0f, 5.0f, 0.0f};
    CHECK(after_a_second(row, true).hash == after_a_second(row, false).hash);
}

TEST_CASE("siblings: pieces that stand on the ground or touch another body press as other bodies do") {
    std::vector<BodyDesc> column = row_of_boxes(4);
    for (size_t i = 0; i < column.size(); ++i)
        column[i].pose.position = {0.0f, 0.1f + 0.2f * static_cast<float>(i), 0.0f};
    CHECK(after_a_second(column, true).hash == after_a_second(column, false).hash);

    // In the air; another body hits the row in the first step.
    const auto hit_row = [](bool siblings, bool other_first) {
        World world;
        const uint32_t number = world.new_siblings();
        BodyDesc other = box({0.1f, 0.1f, 0.1f}, 4.0f, {-0.21f, 1.0f, 0.0f});
        other.linear_velocity = {3.0f, 0.0f, 0.0f};
        if (other_first) must_add(world, other);
        for (BodyDesc& body : row_of_boxes(3)) {
            body.siblings = siblings ? number : 0;
            must_add(world, body);
        }
        if (!other_first) must_add(world, other);
        run(world, 1.0f);
        return world.state_hash();
    };
    for (const bool first : {false, true}) CHECK(hit_row(true, first) == hit_row(false, first));
}

TEST_CASE("siblings: two cuts whose pieces are added in turns are told apart") {
    // The last box of the first row moves into its siblings, at the velocity of the second row.
    const auto outcome = [](bool siblings) {
        World world;
        const uint32_t one = world.new_siblings(), other = world.new_siblings();
        for (BodyDesc& body : row_of_boxes(3)) {
            const bool last = body.pose.position.x > 0.3f;
            // 0.1 mm apart: the places of boxes that only touch round to overlaps in flight.
            body.pose.position.x *= 1.0005f;
            body.siblings = siblings ? one : 0;
            if (last) body.linear_velocity = {-1.5f, 0.0f, 0.0f};
            must_add(world, body);
            body.pose.position.y = 3.0f;
            body.siblings = siblings ? other : 0;
            body.linear_velocity = {-1.5f, 0.0f, 0.0f};
            must_add(world, body);
        }
        run(world, 0.3f);
        return world.state_hash();
    };
    CHECK(outcome(true) == outcome(false));
}

TEST_CASE("siblings: pieces that fall on the ground end as a heap, not inside each other") {
    World world;
    const auto fragments = test::voronoi_pieces({-0.25, 0.4, -0.25}, {0.25, 0.9, 0.25}, 80, 3);
    const auto bodies = add_pieces(world, fragments, {}, {});
    REQUIRE(bodies.has_value());
    world.step();
    CHECK(world.contacts().empty());
    run(world, 4.0f);
    // Pieces are 10 cm wide: a pair that was never searched would be centimetres deep.
    float deepest = 0.0f;
    for (const Contact& contact : world.contacts()) deepest = std::min(deepest, contact.gap);
    CHECK(world.contacts().size() > bodies->size());
    CHECK(deepest > -5e-3f);
}

TEST_CASE("contacts: those of the last step still name a body that was removed since") {
    World world;
    std::vector<BodyDesc> boxes = row_of_boxes(2);
    boxes[0].pose.position = {0.0f, 0.1f, 0.0f};
    boxes[1].pose.position = {0.0f, 0.3f, 0.0f};
    const BodyId below = must_add(world, boxes[0]), above = must_add(world, boxes[1]);
    run(world, 0.2f);
    REQUIRE(world.remove_body(above));
    bool named = false, ground = false;
    for (const Contact& contact : world.contacts()) {
        named = named || contact.a == above || contact.b == above;
        ground = ground || (contact.a == below && contact.b == BodyId{});
    }
    CHECK(named);
    CHECK(ground);
}
