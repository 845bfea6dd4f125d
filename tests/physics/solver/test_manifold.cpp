#include "physics/solver/manifold.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

const glm::vec3 up(0.0f, 1.0f, 0.0f);

// A cube with its middle at the origin.
struct Cube : Body {
    explicit Cube(float half) {
        std::vector<glm::vec3> corners;
        for (int i = 0; i < 8; ++i) corners.push_back(half * glm::vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
        auto shaped = std::make_shared<SolverForm>();
        shaped->shape = HullShape(corners, 0.0f);
        form = std::move(shaped);
    }
};

// Two cubes of 1 m: `a` rests on `b`, whose top is the plane y = 0.
struct Stack {
    Cube a{0.5f}, b{0.5f};
    Manifold manifold;

    Stack() : manifold(place(a, 0.5f), place(b, -0.5f)) {}
    void add(float x, float z, float distance = 0.0f) { manifold.add(up, {x, 0.0f, z}, distance, 0, 0); }
    [[nodiscard]] const ContactPoint* at(float x, float z) const {
        const auto found = std::ranges::find_if(manifold.points(), [&](const ContactPoint& point) {
            return glm::length(point.on_b - glm::vec3(x, 0.0f, z)) < 1e-5f;
        });
        return found == manifold.points().end() ? nullptr : &*found;
    }

  private:
    static const Body& place(Body& body, float height) {
        body.frame = {glm::mat3(1.0f), {0.0f, height, 0.0f}};
        return body;
    }
};

} // namespace

TEST_CASE("manifold: a new one is empty, and its threshold is a fiftieth of the smaller rotation radius") {
    const Cube small(0.1f), large(0.5f);
    Manifold manifold(large, small);
    CHECK(manifold.count() == 0);
    CHECK(manifold.points().empty());
    manifold.refresh();
    CHECK(manifold.count() == 0);
    CHECK(manifold.breaking_threshold() == doctest::Approx(0.02 * std::sqrt(3.0) * 0.1));
    CHECK(Manifold(small, large).breaking_threshold() == manifold.breaking_threshold());
    manifold.set_breaking_threshold(0.5f);
    CHECK(manifold.breaking_threshold() == 0.5f);
}

TEST_CASE("manifold: friction and restitution are the products of the bodies', friction at most 10") {
    Cube a(0.5f), b(0.5f);
    a.friction = 0.5f, b.friction = 0.8f, a.restitution = 0.5f, b.restitution = 0.25f;
    const Manifold manifold(a, b);
    CHECK(manifold.friction() == doctest::Approx(0.4));
    CHECK(manifold.restitution() == doctest::Approx(0.125));
    a.friction = b.friction = 100.0f;
    CHECK(manifold.friction() == 10.0f);
}

TEST_CASE("manifold: a contact knows its points in the world and in the bodies") {
    Stack stack;
    stack.a.frame.basis = matrix_of(glm::angleAxis(1.0f, up));
    stack.manifold.add(up, {0.2f, 0.0f, 0.1f}, 0.01f, 3, 5);
    REQUIRE(stack.manifold.count() == 1);
    const ContactPoint& point = stack.manifold.points()[0];
    CHECK(point.on_b == glm::vec3(0.2f, 0.0f, 0.1f));
    CHECK(point.on_a == glm::vec3(0.2f, 0.01f, 0.1f));
    CHECK(glm::length(stack.a.frame * point.local_a - point.on_a) < 1e-6f);
    CHECK(glm::length(stack.b.frame * point.local_b - point.on_b) < 1e-6f);
    CHECK(point.normal == up);
    CHECK(point.distance == 0.01f);
    CHECK(point.part_a == 3);
    CHECK(point.part_b == 5);
    CHECK(point.normal_impulse == 0.0f);
    CHECK(point.friction_impulse == 0.0f);
    CHECK(std::abs(glm::dot(point.tangent, up)) < 1e-6f);
    CHECK(std::abs(glm::length(point.tangent) - 1.0f) < 1e-6f);
}

TEST_CASE("manifold: a point beyond the breaking threshold is not added, any overlap is") {
    Stack stack;
    const float threshold = stack.manifold.breaking_threshold();
    stack.add(0.0f, 0.0f, 1.01f * threshold);
    CHECK(stack.manifold.count() == 0);
    stack.add(0.0f, 0.0f, threshold);
    CHECK(stack.manifold.count() == 1);
    stack.add(0.3f, 0.0f, -10.0f);
    CHECK(stack.manifold.count() == 2);
    stack.manifold.clear();
    CHECK(stack.manifold.count() == 0);
}

TEST_CASE("manifold: a point within the threshold of a known one replaces it and keeps its impulses") {
    Stack stack;
    const float threshold = stack.manifold.breaking_threshold();
    stack.add(0.0f, 0.0f);
    stack.add(1.2f * threshold, 0.0f);
    REQUIRE(stack.manifold.count() == 2);
    for (size_t i = 0; i < 2; ++i) {
        stack.manifold.points()[i].normal_impulse = 10.0f + static_cast<float>(i);
        stack.manifold.points()[i].friction_impulse = 20.0f + static_cast<float>(i);
    }
    stack.add(0.7f * threshold, 0.0f, -0.001f); // near both, nearer to the second
    CHECK(stack.manifold.count() == 2);
    CHECK(stack.at(0.0f, 0.0f) != nullptr);
    CHECK(stack.at(1.2f * threshold, 0.0f) == nullptr);
    const ContactPoint* const moved = stack.at(0.7f * threshold, 0.0f);
    REQUIRE(moved);
    CHECK(moved->normal_impulse == 11.0f);
    CHECK(moved->friction_impulse == 21.0f);
    CHECK(moved->distance == -0.001f);
    stack.add(-1.01f * threshold, 0.0f); // a contact of its own
    CHECK(stack.manifold.count() == 3);
    CHECK(stack.at(-1.01f * threshold, 0.0f)->normal_impulse == 0.0f);
}

TEST_CASE("manifold: a fifth point replaces the corner of a square that it lies outside of") {
    for (const float x : {-0.3f, 0.3f})
        for (const float z : {-0.3f, 0.3f}) {
            Stack stack;
            for (const float corner_x : {-0.3f, 0.3f})
                for (const float corner_z : {-0.3f, 0.3f}) stack.add(corner_x, corner_z);
            stack.add(1.5f * x, 1.5f * z);
            CHECK(stack.manifold.count() == 4);
            CHECK(stack.at(1.5f * x, 1.5f * z) != nullptr);
            CHECK(stack.at(x, z) == nullptr);
            CHECK(stack.at(-x, z) != nullptr);
            CHECK(stack.at(x, -z) != nullptr);
            CHECK(stack.at(-x, -z) != nullptr);
        }
}

TEST_CASE("manifold: of five points the new one and the deepest stay") {
    for (const float x : {-0.3f, 0.3f})
        for (const float z : {-0.3f, 0.3f}) {
            Stack stack;
            for (const float corner_x : {-0.3f, 0.3f})
                for (const float corner_z : {-0.3f, 0.3f})
                    stack.add(corner_x, corner_z, corner_x == x && corner_z == z ? -0.01f : 0.0f);
            stack.add(1.5f * x, 1.5f * z, -0.005f);
            CHECK(stack.manifold.count() == 4);
            CHECK(stack.at(x, z) != nullptr);
            CHECK(stack.at(1.5f * x, 1.5f * z) != nullptr);
        }
    test::Random random(3);
    for (int i = 0; i < 2000; ++i) {
        Stack stack;
        float deepest = 0.0f, deepest_x = 0.0f, deepest_z = 0.0f;
        for (int point = 0; point < 12; ++point) {
            const auto x = static_cast<float>(random.uniform(-0.5, 0.5));
            const auto z = static_cast<float>(random.uniform(-0.5, 0.5));
            const auto depth = static_cast<float>(random.uniform(0.0, 0.1));
            stack.add(x, z, -depth);
            CHECK(stack.manifold.count() <= Manifold::max_points);
            REQUIRE(stack.at(x, z)); // the new one
            const bool near_deepest = glm::length(glm::vec3(x - deepest_x, 0.0f, z - deepest_z))
                                      < 2.0f * stack.manifold.breaking_threshold(); // may take its place
            if (depth > deepest || near_deepest) deepest = depth, deepest_x = x, deepest_z = z;
            if (near_deepest) break;
            CHECK(stack.at(deepest_x, deepest_z) != nullptr);
        }
    }
}

TEST_CASE("manifold: points follow the bodies, and end beyond the threshold along and across the normal") {
    const auto left_after = [](const glm::vec3& way) {
        Stack stack;
        for (const float x : {-0.3f, 0.3f})
            for (const float z : {-0.3f, 0.3f}) stack.add(x, z);
        stack.a.frame.origin += way;
        stack.manifold.refresh();
        for (const ContactPoint& point : stack.manifold.points()) {
            CHECK(std::abs(point.distance - way.y) < 1e-6f);
            CHECK(glm::length(point.on_a - point.on_b - way) < 1e-6f);
        }
        return stack.manifold.count();
    };
    const float threshold = Stack().manifold.breaking_threshold();
    CHECK(left_after(glm::vec3(0.0f)) == 4);
    CHECK(left_after({0.0f, 0.99f * threshold, 0.0f}) == 4);
    CHECK(left_after({0.0f, 1.01f * threshold, 0.0f}) == 0);
    CHECK(left_after({0.0f, -20.0f * threshold, 0.0f}) == 4); // deeper
    CHECK(left_after({0.99f * threshold, 0.0f, 0.0f}) == 4);
    CHECK(left_after({0.0f, 0.0f, -1.01f * threshold}) == 0);
    CHECK(left_after({0.8f * threshold, 0.0f, 0.8f * threshold}) == 0);
    CHECK(left_after({0.6f * threshold, 0.6f * threshold, 0.6f * threshold}) == 4);
}

TEST_CASE("manifold: a body that tips keeps the two points that it tips over, with their impulses") {
    Stack stack;
    for (const float x : {-0.5f, 0.5f})
        for (const float z : {-0.5f, 0.5f}) stack.add(x, z);
    for (ContactPoint& point : stack.manifold.points()) point.normal_impulse = 7.0f + point.on_b.x;
    const float angle = 2.0f * stack.manifold.breaking_threshold(); // the points at +X rise by as much
    const glm::quat rotation = glm::angleAxis(angle, glm::vec3(0.0f, 0.0f, 1.0f));
    const glm::vec3 edge(-0.5f, 0.0f, 0.0f);
    stack.a.frame = {matrix_of(rotation), edge + rotation * (stack.a.frame.origin - edge)};
    stack.manifold.refresh();
    REQUIRE(stack.manifold.count() == 2);
    for (const ContactPoint& point : stack.manifold.points()) {
        CHECK(point.on_b.x == -0.5f);
        CHECK(point.normal_impulse == 6.5f);
        CHECK(std::abs(point.distance) < 1e-6f);
    }
}

TEST_CASE("manifold: warm starting on the ground begins at nothing after a blow, and at the last impulse else") {
    GroundPoint point;
    point.speed = blow_speed;
    point.take(3.0f, -2.0f);
    CHECK_FALSE(point.blow);
    CHECK(point.warm_normal_impulse() == 3.0f);
    CHECK(point.warm_friction_impulse() == -2.0f);
    point.speed = 1.01f * blow_speed;
    point.take(3.0f, -2.0f);
    CHECK(point.blow);
    CHECK(point.warm_normal_impulse() == 0.0f);
    CHECK(point.warm_friction_impulse() == 0.0f);
    CHECK(point.normal_impulse == 3.0f); // still reported
}
