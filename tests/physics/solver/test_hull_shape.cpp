#include "physics/solver/hull_shape.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <doctest/doctest.h>

using namespace brittle::physics;

namespace {

struct Made {
    HullShape shape;
    std::vector<btVector3> points;

    Made(int count, float size, float margin, std::mt19937& random) {
        const auto number = [&] { return size * (static_cast<float>(random() >> 8) / 8388608.0f - 1.0f); };
        for (int i = 0; i < count; ++i) {
            points.emplace_back(0, 0, 0);
            for (int axis = 0; axis < 3; ++axis) points.back()[axis] = number();
        }
        for (const btVector3& point : points) shape.addPoint(point, false);
        shape.setMargin(margin);
        shape.finish();
    }
};

// About 1e-6 relative: the sums may be taken in another order.
bool close(float a, float b, float scale) {
    return std::abs(a - b) <= 2e-6f * scale;
}

} // namespace

TEST_CASE("reach, farthest point, box and radius are those of the points, for any number of them") {
    std::mt19937 random(3);
    for (const int count : {1, 2, 3, 4, 5, 7, 8, 13, 31, 32, 33}) {
        const Made made(count, 2.0f, 0.25f, random);
        btTransform frame(btQuaternion(btVector3(1, 2, -3).normalized(), 0.1f * static_cast<float>(count)),
                          btVector3(5, -6, 7));
        btVector3 low, high, expected_low(1e9f, 1e9f, 1e9f), expected_high = -expected_low;
        made.shape.getAabb(frame, low, high);
        float radius = 0.0f;
        for (const btVector3& point : made.points) {
            expected_low.setMin(frame * point);
            expected_high.setMax(frame * point);
            radius = std::max(radius, point.length());
        }
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(close(low[axis], expected_low[axis] - 0.25f, 10.0f));
            CHECK(close(high[axis], expected_high[axis] + 0.25f, 10.0f));
        }
        CHECK(close(made.shape.radius(), radius + 0.25f, 4.0f));
        CHECK(made.shape.getAngularMotionDisc() == made.shape.btConvexHullShape::getAngularMotionDisc());
        made.shape.getAabb(btTransform::getIdentity(), low, high);
        CHECK(made.shape.longest() == std::max({high.x() - low.x(), high.y() - low.y(), high.z() - low.z()}));
        for (int i = 0; i < 20; ++i) {
            const btVector3 direction = Made(1, 1.0f, 0.0f, random).points[0];
            float most = -1e9f;
            for (const btVector3& point : made.points) most = std::max(most, direction.dot(point));
            CHECK(close(made.shape.reach(direction), most, 4.0f));
            const int at = made.shape.farthest(direction);
            REQUIRE((at >= 0 && at < count));
            CHECK(close(direction.dot(made.points[static_cast<size_t>(at)]), most, 4.0f));
        }
    }
}

TEST_CASE("of points that reach equally far the first is the farthest, and no direction has one too") {
    HullShape shape;
    for (const float x : {0.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f}) shape.addPoint({x, 0, 0}, false);
    shape.finish();
    CHECK(shape.farthest({1, 0, 0}) == 1);
    CHECK(shape.farthest({0, 0, 0}) == 0);
    const float no_number = std::nanf("");
    const int some = shape.farthest({no_number, no_number, no_number});
    CHECK((some >= 0 && some < 6));
}
