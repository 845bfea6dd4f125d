#include "physics/solver/hull_shape.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <doctest/doctest.h>
#include <glm/gtc/quaternion.hpp>

using namespace brittle::physics;

namespace {

std::vector<glm::vec3> random_points(int count, float size, std::mt19937& random) {
    std::vector<glm::vec3> points(static_cast<size_t>(count));
    for (glm::vec3& point : points)
        for (int axis = 0; axis < 3; ++axis)
            point[axis] = size * (static_cast<float>(random() >> 8) / 8388608.0f - 1.0f);
    return points;
}

// Equal up to the order in which sums are taken, about 1e-6 of the scale.
bool close(float a, float b, float scale) {
    return std::abs(a - b) <= 2e-6f * scale;
}

float longest_side(const Bounds& box) {
    const glm::vec3 size = box.high - box.low;
    return std::max({size.x, size.y, size.z});
}

} // namespace

TEST_CASE("hull shape: support, bounds and radii match a loop over the points, for any number of points") {
    std::mt19937 random(3);
    for (const int count : {1, 2, 3, 4, 5, 7, 8, 13, 31, 32, 33}) {
        CAPTURE(count);
        const std::vector<glm::vec3> points = random_points(count, 2.0f, random);
        const HullShape shape(points, 0.25f);
        CHECK(shape.points() == points);
        CHECK(shape.point_count() == count);
        CHECK(shape.margin() == 0.25f);
        const glm::quat rotation =
            glm::angleAxis(0.1f * static_cast<float>(count), glm::normalize(glm::vec3(1, 2, -3)));
        const Transform frame{matrix_of(rotation), {5, -6, 7}};
        const Bounds box = shape.bounds(frame);
        glm::vec3 expected_low(1e9f), expected_high(-1e9f);
        float radius = 0.0f;
        for (const glm::vec3& point : points) {
            expected_low = glm::min(expected_low, frame * point);
            expected_high = glm::max(expected_high, frame * point);
            radius = std::max(radius, glm::length(point));
        }
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(close(box.low[axis], expected_low[axis] - 0.25f, 10.0f));
            CHECK(close(box.high[axis], expected_high[axis] + 0.25f, 10.0f));
        }
        CHECK(close(shape.radius(), radius + 0.25f, 4.0f));
        const Bounds own = shape.bounds({});
        CHECK(shape.longest() == longest_side(own));
        CHECK(shape.rotation_radius() == rotation_radius(own));
        CHECK(shape.rotation_radius()
              == doctest::Approx(0.5f * (glm::length(own.high - own.low) + glm::length(own.high + own.low))));
        for (const glm::vec3& point : points) // from any axis through the origin
            CHECK(glm::length(point) <= shape.rotation_radius());
        for (int i = 0; i < 20; ++i) {
            const glm::vec3 direction = random_points(1, 1.0f, random)[0];
            float most = -1e9f, max_in_world = -1e9f;
            for (const glm::vec3& point : points) {
                most = std::max(most, glm::dot(direction, point));
                max_in_world = std::max(max_in_world, glm::dot(direction, frame * point));
            }
            CHECK(close(shape.support(direction), most, 4.0f));
            CHECK(close(support(shape, frame, direction), max_in_world, 20.0f));
            const int at = shape.support_index(direction);
            REQUIRE((at >= 0 && at < count));
            CHECK(close(glm::dot(direction, points[static_cast<size_t>(at)]), most, 4.0f));
        }
    }
}

TEST_CASE("hull shape: the support index is the first of equal points, and valid for a zero and a NaN direction") {
    std::vector<glm::vec3> points;
    for (const float x : {0.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f}) points.emplace_back(x, 0, 0);
    const HullShape shape(points, 0.0f);
    CHECK(shape.support_index({1, 0, 0}) == 1);
    CHECK(shape.support_index({0, 0, 0}) == 0);
    const int some = shape.support_index(glm::vec3(std::nanf("")));
    CHECK((some >= 0 && some < 6));
}
