#include "physics/solver/transform.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

float largest_difference(const glm::mat3& a, const glm::mat3& b) {
    float most = 0.0f;
    for (int column = 0; column < 3; ++column)
        for (int axis = 0; axis < 3; ++axis) most = std::max(most, std::abs(a[column][axis] - b[column][axis]));
    return most;
}

// The branch of rotation_of(): 3 for a positive trace, else the axis of the largest diagonal element.
int branch_of(const glm::mat3& m) {
    if (m[0][0] + m[1][1] + m[2][2] > 0.0f) return 3;
    int largest = 0;
    for (int axis : {1, 2})
        if (m[axis][axis] > m[largest][largest]) largest = axis;
    return largest;
}

glm::vec3 random_vector(test::Random& random, double size) {
    return glm::vec3(random.point(glm::dvec3(-size), glm::dvec3(size)));
}

glm::quat random_rotation(test::Random& random) {
    return glm::angleAxis(static_cast<float>(random.uniform(-std::numbers::pi, std::numbers::pi)),
                          glm::vec3(random.direction()));
}

Transform random_transform(test::Random& random) {
    return {matrix_of(random_rotation(random)), random_vector(random, 5.0)};
}

} // namespace

TEST_CASE("transform: the identity quaternion is the identity matrix, both ways") {
    CHECK(matrix_of(glm::quat(1.0f, 0.0f, 0.0f, 0.0f)) == glm::mat3(1.0f));
    CHECK(rotation_of(glm::mat3(1.0f)) == glm::quat(1.0f, 0.0f, 0.0f, 0.0f));
    const Transform none;
    CHECK(none * glm::vec3(1, 2, 3) == glm::vec3(1, 2, 3));
    CHECK(none.inverse() == none);
}

TEST_CASE("transform: half turns about the axes, the face diagonals and the space diagonals survive a round trip") {
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z) {
                if (x == 0 && y == 0 && z == 0) continue;
                CAPTURE(x);
                CAPTURE(y);
                CAPTURE(z);
                const glm::vec3 axis = glm::normalize(glm::vec3(x, y, z));
                const glm::mat3 matrix = matrix_of(glm::quat(0.0f, axis.x, axis.y, axis.z));
                CHECK(largest_difference(matrix, 2.0f * glm::outerProduct(axis, axis) - glm::mat3(1.0f)) < 1e-6f);
                const glm::quat back = rotation_of(matrix);
                CHECK(std::abs(back.w) < 1e-6f);
                CHECK(std::abs(std::abs(glm::dot(glm::vec3(back.x, back.y, back.z), axis)) - 1.0f) < 1e-6f);
            }
}

TEST_CASE("transform: quaternion and matrix give each other back, in every branch") {
    test::Random random(1);
    std::array<int, 4> branches{};
    for (int i = 0; i < 4000; ++i) {
        const glm::quat q = random_rotation(random);
        const glm::mat3 matrix = matrix_of(q);
        CHECK(largest_difference(matrix, glm::mat3(glm::mat3_cast(glm::normalize(glm::dquat(q))))) < 1e-6f);
        CHECK(largest_difference(glm::transpose(matrix) * matrix, glm::mat3(1.0f)) < 2e-6f);
        CHECK(std::abs(glm::determinant(matrix) - 1.0f) < 2e-6f);
        ++branches[static_cast<size_t>(branch_of(matrix))];
        const glm::quat back = rotation_of(matrix); // q or -q
        CHECK(std::abs(glm::length(back) - 1.0f) < 2e-6f);
        CHECK(std::abs(std::abs(glm::dot(back, q)) - 1.0f) < 2e-6f);
        CHECK(largest_difference(matrix_of(back), matrix) < 2e-6f);
    }
    for (const int count : branches) CHECK(count > 100);
}

TEST_CASE("transform: a quaternion of any length has the matrix of its unit quaternion") {
    test::Random random(2);
    for (const float length : {1e-6f, 0.1f, 2.0f, 1e6f})
        for (int i = 0; i < 50; ++i) {
            const glm::quat q = random_rotation(random);
            CHECK(largest_difference(matrix_of(q * length), matrix_of(q)) < 2e-6f);
        }
}

TEST_CASE("transform: products, inverses and local coordinates agree") {
    test::Random random(3);
    for (int i = 0; i < 500; ++i) {
        const Transform a = random_transform(random), b = random_transform(random);
        const glm::vec3 point = random_vector(random, 3.0);
        const auto near = [](const glm::vec3& p, const glm::vec3& q) { return glm::length(p - q) < 2e-5f; };
        CHECK(near((a * b) * point, a * (b * point)));
        CHECK(near(a.to_local(a * point), point));
        CHECK(near(a.inverse() * point, a.to_local(point)));
        const Transform b_in_a = a.to_local(b), product = a.inverse() * b, whole = a * b_in_a;
        CHECK(largest_difference(b_in_a.basis, product.basis) < 2e-6f);
        CHECK(near(b_in_a.origin, product.origin));
        CHECK(largest_difference(whole.basis, b.basis) < 2e-6f);
        CHECK(near(whole.origin, b.origin));
        for (int axis = 0; axis < 3; ++axis) {
            glm::vec3 unit(0.0f);
            unit[axis] = 1.0f;
            CHECK(row(a.basis, axis) == glm::transpose(a.basis)[axis]);
            CHECK(near(a.basis * row(a.basis, axis), unit)); // the world axis in local axes
        }
    }
}

TEST_CASE("transform: tangents make a right-handed frame with every unit normal") {
    const auto check = [](const glm::vec3& n) {
        CAPTURE(n.x);
        CAPTURE(n.y);
        CAPTURE(n.z);
        const Tangents t = tangents_of(n);
        CHECK(std::abs(glm::length(t.first) - 1.0f) < 1e-6f);
        CHECK(std::abs(glm::length(t.second) - 1.0f) < 2e-6f);
        CHECK(std::abs(glm::dot(n, t.first)) < 1e-6f);
        CHECK(std::abs(glm::dot(n, t.second)) < 1e-6f);
        CHECK(glm::length(glm::cross(n, t.first) - t.second) < 2e-6f);
    };
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z)
                if (x != 0 || y != 0 || z != 0) check(glm::normalize(glm::vec3(x, y, z)));
    for (const float z : {std::nextafter(0.70710678f, 0.0f), 0.70710678f, std::nextafter(0.70710678f, 1.0f)})
        for (const float sign : {-1.0f, 1.0f}) // both sides of the branch
            for (const float angle : {0.0f, 0.5f, 1.5707964f, 3.0f}) {
                const float across = std::sqrt(1.0f - z * z);
                check({across * std::cos(angle), across * std::sin(angle), sign * z});
            }
    test::Random random(4);
    for (int i = 0; i < 500; ++i) check(glm::vec3(random.direction()));
}

TEST_CASE("bounds: boxes that touch overlap, and boxes that are apart along one axis do not") {
    const Bounds unit{glm::vec3(0.0f), glm::vec3(1.0f)};
    CHECK(unit.overlaps(unit));
    CHECK(unit.overlaps({glm::vec3(0.4f), glm::vec3(0.4f)})); // a point inside
    for (int axis = 0; axis < 3; ++axis)
        for (const float sign : {-1.0f, 1.0f}) {
            Bounds other = unit;
            other.low[axis] += sign, other.high[axis] += sign;
            CHECK(unit.overlaps(other));
            CHECK(other.overlaps(unit));
            other.low[axis] += sign * 1e-6f, other.high[axis] += sign * 1e-6f;
            CHECK_FALSE(unit.overlaps(other));
            CHECK_FALSE(other.overlaps(unit));
        }
}

TEST_CASE("bounds: grown, united and rotated boxes hold what they must, and no more") {
    const Bounds box{{-1, 0, 2}, {1, 3, 4}};
    const Bounds grown = box.grown({0.5f, -0.5f, 0.0f}, 0.25f);
    CHECK(grown.low == glm::vec3(-1.25f, -0.75f, 1.75f));
    CHECK(grown.high == glm::vec3(1.75f, 3.25f, 4.25f));
    const Bounds united = both(box, {{0, -5, 3}, {9, 1, 3}});
    CHECK(united.low == glm::vec3(-1, -5, 2));
    CHECK(united.high == glm::vec3(9, 3, 4));

    test::Random random(5);
    for (int i = 0; i < 200; ++i) {
        const Transform frame = random_transform(random);
        const glm::vec3 a = random_vector(random, 2.0), b = random_vector(random, 2.0);
        const Bounds own{glm::min(a, b), glm::max(a, b)}, rotated = own.in(frame);
        glm::vec3 low(1e9f), high(-1e9f);
        for (int corner = 0; corner < 8; ++corner) {
            const glm::vec3 at = frame
                                 * glm::vec3(corner & 1 ? own.low.x : own.high.x, corner & 2 ? own.low.y : own.high.y,
                                             corner & 4 ? own.low.z : own.high.z);
            low = glm::min(low, at), high = glm::max(high, at);
        }
        CHECK(glm::length(rotated.low - low) < 1e-5f);
        CHECK(glm::length(rotated.high - high) < 1e-5f);
    }
}
