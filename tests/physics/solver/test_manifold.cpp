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
    [[nodiscard]] ContactPoint point(float x, float z, float distance = 0.0f, uint32_t feature = no_feature) const {
        ContactPoint made = manifold.point_at(up, {x, 0.0f, z}, distance);
        made.feature = feature;
        return made;
    }
    void add(float x, float z, float distance = 0.0f) { manifold.add(point(x, z, distance)); }
    void replace(std::vector<ContactPoint> candidates) { manifold.replace(candidates); }
    // Marks the points as a solution leaves them.
    void mark() {
        for (size_t i = 0; i < manifold.count(); ++i) {
            const float mark = 1.0f + static_cast<float>(i);
            manifold.points()[i].last = {mark, {10.0f * mark, 0.0f, 0.0f}};
            manifold.points()[i].start = {100.0f * mark, {0.0f, 0.0f, 1000.0f * mark}};
        }
    }
    // The number that mark() gave to the point there; 0 for a new one.
    [[nodiscard]] float mark_at(float x, float z) const {
        const ContactPoint* const point = at(x, z);
        REQUIRE(point);
        const float mark = point->last.normal;
        CHECK(point->last.friction == glm::vec3(10.0f * mark, 0.0f, 0.0f));
        CHECK(point->start.normal == 100.0f * mark);
        CHECK(point->start.friction == glm::vec3(0.0f, 0.0f, 1000.0f * mark));
        return mark;
    }
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

TEST_CASE("manifold: a contact knows its points and normal in the world and in the bodies") {
    Stack stack;
    stack.a.frame.basis = matrix_of(glm::angleAxis(1.0f, glm::vec3(1.0f, 0.0f, 0.0f)));
    const ContactPoint point = stack.point(0.2f, 0.1f, 0.01f);
    CHECK(point.on_b == glm::vec3(0.2f, 0.0f, 0.1f));
    CHECK(point.on_a == glm::vec3(0.2f, 0.01f, 0.1f));
    CHECK(glm::length(stack.a.frame * point.local_a - point.on_a) < 1e-6f);
    CHECK(glm::length(stack.b.frame * point.local_b - point.on_b) < 1e-6f);
    CHECK(point.normal == up);
    CHECK(glm::length(stack.a.frame.basis * point.local_normal - up) < 1e-6f);
    CHECK(point.distance == 0.01f);
    CHECK(point.feature == no_feature);
    CHECK(point.last.normal == 0.0f);
    CHECK(point.last.friction == glm::vec3(0.0f));
    CHECK(point.start.normal == 0.0f);
    CHECK(point.start.friction == glm::vec3(0.0f));
    CHECK(stack.manifold.count() == 0);
    stack.manifold.add(point);
    CHECK(stack.manifold.count() == 1);
}

TEST_CASE("manifold: no candidate leaves no point, and up to four stay in their order, near or far") {
    Stack stack;
    stack.add(0.1f, 0.1f);
    stack.replace({});
    CHECK(stack.manifold.count() == 0);
    for (size_t count = 1; count <= Manifold::max_points; ++count) {
        std::vector<ContactPoint> candidates;
        for (size_t i = 0; i < count; ++i) candidates.push_back(stack.point(0.1f, 0.0f, static_cast<float>(i) - 2.0f));
        stack.replace(candidates); // all at one place
        REQUIRE(stack.manifold.count() == count);
        for (size_t i = 0; i < count; ++i) CHECK(stack.manifold.points()[i].distance == static_cast<float>(i) - 2.0f);
    }
}

TEST_CASE("manifold: a point continues the old one with its feature, wherever that was") {
    Stack stack;
    stack.replace({stack.point(0.3f, 0.3f, 0.0f, 7), stack.point(-0.3f, 0.3f, 0.0f, 8),
                   stack.point(-0.3f, -0.3f, 0.0f, 9), stack.point(0.3f, -0.3f, 0.0f, 10)});
    stack.mark();
    stack.replace({stack.point(-0.3f, 0.301f, 0.0f, 9), stack.point(0.3f, 0.301f, 0.0f, 10),
                   stack.point(-0.3f, -0.301f, 0.0f, 11)});
    CHECK(stack.manifold.count() == 3);
    CHECK(stack.mark_at(-0.3f, 0.301f) == 3.0f); // 9, though 8 was there
    CHECK(stack.mark_at(0.3f, 0.301f) == 4.0f);
    CHECK(stack.mark_at(-0.3f, -0.301f) == 0.0f); // the old point there continues elsewhere
}

TEST_CASE("manifold: a point of a new feature continues the nearest old one within the threshold") {
    Stack stack;
    const float threshold = stack.manifold.breaking_threshold();
    stack.replace({stack.point(0.0f, 0.0f, 0.0f, 1), stack.point(1.2f * threshold, 0.0f)});
    stack.mark();
    stack.replace({stack.point(0.7f * threshold, 0.0f, -0.001f, 2)}); // near both
    REQUIRE(stack.manifold.count() == 1);
    CHECK(stack.mark_at(0.7f * threshold, 0.0f) == 2.0f);
    CHECK(stack.manifold.points()[0].distance == -0.001f);
    CHECK(stack.manifold.points()[0].feature == 2);
    stack.mark();
    stack.replace({stack.point(1.8f * threshold, 0.0f)}); // too far
    CHECK(stack.mark_at(1.8f * threshold, 0.0f) == 0.0f);
}

TEST_CASE("manifold: an old point continues once, and features come before places") {
    Stack stack;
    stack.replace({stack.point(0.0f, 0.0f, 0.0f, 5)});
    stack.mark();
    // The first candidate is at the old place; the last has the old feature.
    stack.replace({stack.point(0.0f, 0.0f, 0.0f, 6), stack.point(0.0f, 0.001f), stack.point(0.3f, 0.0f, 0.0f, 5)});
    CHECK(stack.mark_at(0.0f, 0.0f) == 0.0f);
    CHECK(stack.mark_at(0.0f, 0.001f) == 0.0f);
    CHECK(stack.mark_at(0.3f, 0.0f) == 1.0f);
    stack.mark();
    stack.replace({stack.point(0.3f, 0.1f, 0.0f, 5), stack.point(0.3f, 0.2f, 0.0f, 5)}); // the first of two
    CHECK(stack.mark_at(0.3f, 0.1f) == 3.0f);
    CHECK(stack.mark_at(0.3f, 0.2f) == 0.0f);
    // Two points without a feature do not count as the same one.
    Stack other;
    other.replace({other.point(0.0f, 0.0f)});
    other.mark();
    other.replace({other.point(0.4f, 0.0f), other.point(0.0f, 0.0005f), other.point(0.0f, 0.0f)});
    CHECK(other.mark_at(0.4f, 0.0f) == 0.0f);
    CHECK(other.mark_at(0.0f, 0.0005f) == 1.0f);
    CHECK(other.mark_at(0.0f, 0.0f) == 0.0f);
}

TEST_CASE("manifold: the four corners of a square stay, and not the points between them") {
    Stack stack;
    std::vector<ContactPoint> candidates;
    for (int x = -2; x <= 2; ++x)
        for (int z = -2; z <= 2; ++z)
            candidates.push_back(stack.point(0.1f * static_cast<float>(x), 0.1f * static_cast<float>(z),
                                             x == 2 && z == 2 ? -0.001f : 0.0f));
    for (int turn = 0; turn < 5; ++turn) { // in any order
        stack.replace(candidates);
        CHECK(stack.manifold.count() == 4);
        for (const float x : {-0.2f, 0.2f})
            for (const float z : {-0.2f, 0.2f}) CHECK(stack.at(x, z) != nullptr);
        std::rotate(candidates.begin(), candidates.begin() + 7, candidates.end());
        std::ranges::reverse(candidates.begin() + 3, candidates.end());
    }
}

// Each point in its turn must be the best of the candidates that are left, by double arithmetic up to rounding.
TEST_CASE("manifold: of many candidates the deepest stays, and those that span the largest area with it") {
    test::Random random(3);
    for (int round = 0; round < 2000; ++round) {
        CAPTURE(round);
        Stack stack;
        std::vector<ContactPoint> candidates;
        const int count = 5 + static_cast<int>(random.uniform(0.0, 20.0));
        const double narrow = round % 4 == 0 ? 0.0 : 0.5; // on a line
        for (int i = 0; i < count; ++i) {
            const double x = random.uniform(-0.5, 0.5), z = random.uniform(-narrow, narrow);
            const double depth = random.uniform(0.0, 0.1);
            candidates.push_back(stack.point(static_cast<float>(x), static_cast<float>(z), -static_cast<float>(depth)));
        }
        stack.replace(candidates);
        REQUIRE(stack.manifold.count() == 4);
        const auto points = stack.manifold.points();
        const auto place = [](const ContactPoint& p) { return glm::dvec3(p.on_b); };
        const glm::dvec3 first = place(points[0]), line = place(points[1]) - first;
        const auto side = [&](const ContactPoint& p) { return glm::cross(line, place(p) - first).y; };
        double farthest = 0.0, widest = 0.0, left = 0.0, right = 0.0;
        for (const ContactPoint& other : candidates) {
            CHECK(points[0].distance <= other.distance);
            farthest = std::max(farthest, glm::length(place(other) - first));
            widest = std::max(widest, std::abs(side(other)));
            left = std::max(left, side(other));
            right = std::max(right, -side(other));
        }
        CHECK(glm::length(line) >= farthest - 1e-6);
        CHECK(std::abs(side(points[2])) >= widest - 1e-6);
        const bool third_is_left = side(points[2]) > 0.0;
        const double opposite = third_is_left ? right : left;
        if (opposite > 1e-6) CHECK((third_is_left ? -1.0 : 1.0) * side(points[3]) >= opposite - 1e-6);
        for (size_t i = 0; i < 4; ++i)
            for (size_t k = 0; k < i; ++k) CHECK(points[i].on_b != points[k].on_b); // four candidates, each once
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
    for (ContactPoint& point : stack.manifold.points()) point.start.normal = 7.0f + point.on_b.x;
    const float angle = 2.0f * stack.manifold.breaking_threshold(); // the points at +X rise by as much
    const glm::quat rotation = glm::angleAxis(angle, glm::vec3(0.0f, 0.0f, 1.0f));
    const glm::vec3 edge(-0.5f, 0.0f, 0.0f);
    stack.a.frame = {matrix_of(rotation), edge + rotation * (stack.a.frame.origin - edge)};
    stack.manifold.refresh();
    REQUIRE(stack.manifold.count() == 2);
    for (const ContactPoint& point : stack.manifold.points()) {
        CHECK(point.on_b.x == -0.5f);
        CHECK(point.start.normal == 6.5f);
        CHECK(std::abs(point.distance) < 1e-6f);
    }
}

TEST_CASE("manifold: normals turn with body a and not with body b") {
    const glm::quat turn = glm::angleAxis(0.01f, glm::normalize(glm::vec3(1.0f, 2.0f, 3.0f)));
    for (const bool of_a : {true, false}) {
        Stack stack;
        stack.add(0.0f, 0.0f, -0.01f);
        Body& body = of_a ? static_cast<Body&>(stack.a) : stack.b;
        const glm::vec3 pivot(0.0f);
        body.frame = {matrix_of(turn), pivot + turn * (body.frame.origin - pivot)};
        stack.manifold.refresh();
        REQUIRE(stack.manifold.count() == 1);
        const ContactPoint& point = stack.manifold.points()[0];
        CHECK(glm::length(point.normal - (of_a ? turn * up : up)) < 1e-6f);
        CHECK(std::abs(glm::length(point.normal) - 1.0f) < 1e-6f);
        CHECK(std::abs(point.distance - glm::dot(point.on_a - point.on_b, point.normal)) < 1e-7f);
    }
}
