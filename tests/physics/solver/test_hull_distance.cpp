#include "physics/solver/hull_distance.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <random>
#include <vector>

#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <doctest/doctest.h>

using namespace brittle::physics;

namespace {

constexpr float far_away = 1e6f; // a limit beyond everything here

struct Random {
    std::mt19937 engine{11};
    float number(float low, float high) { return low + (high - low) * static_cast<float>(engine() >> 8) / 16777216.0f; }
    btVector3 direction() {
        btVector3 v(0, 0, 0);
        do
            for (int axis = 0; axis < 3; ++axis) v[axis] = number(-1, 1);
        while (v.length2() > 1.0f || v.length2() < 0.01f);
        return v.normalized();
    }
    btTransform frame(float space) {
        const btVector3 axis = direction(), away = direction();
        const float angle = number(0, 6);
        return btTransform(btQuaternion(axis, angle), away * number(0, space));
    }
};

std::unique_ptr<HullShape> hull_of(const std::vector<btVector3>& points) {
    auto shape = std::make_unique<HullShape>();
    for (const btVector3& point : points) shape->addPoint(point, false);
    shape->setMargin(0.0f);
    shape->finish();
    return shape;
}
std::unique_ptr<HullShape> box(float x, float y, float z) {
    std::vector<btVector3> points;
    for (int i = 0; i < 8; ++i) points.emplace_back(i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z);
    return hull_of(points);
}
// Points on an ellipsoid.
std::unique_ptr<HullShape> pebble(int count, const btVector3& radii, Random& random) {
    std::vector<btVector3> points;
    for (int i = 0; i < count; ++i) points.push_back(random.direction() * radii);
    return hull_of(points);
}

double reach(const HullShape& hull, const btTransform& frame, const btVector3& direction) {
    double most = -1e30;
    for (int i = 0; i < hull.getNumPoints(); ++i)
        most = std::max(most, static_cast<double>((frame * hull.getUnscaledPoints()[i]).dot(direction)));
    return most;
}
// How far the hulls are apart in a direction from the second to the first; below 0: how far they overlap along it.
double gap(const HullShape& a, const HullShape& b, const btTransform& b_in_a, const btVector3& direction) {
    return -reach(a, btTransform::getIdentity(), -direction) - reach(b, b_in_a, direction);
}

// A distance is right if the normal separates by as much (it is not less), and if the two points are in their hulls (it is
// not more); that a point is in a hull is asked in many directions.
void check_certificate(const HullShape& a, const HullShape& b, const btTransform& b_in_a, const HullDistance& found,
                       Random& random) {
    // Positions are rounded to 1e-7 of the coordinates, so what is small and far from the first's origin has less.
    const double bound =
        3e-5 * static_cast<double>(a.radius() + b.radius()) + 4e-7 * static_cast<double>(b_in_a.getOrigin().length());
    CHECK(std::abs(found.normal.length() - 1.0f) < 1e-5f);
    CHECK(std::abs(gap(a, b, b_in_a, found.normal) - static_cast<double>(found.distance)) < bound);
    const btVector3 on_first = found.point + found.normal * found.distance;
    for (int i = 0; i < 60; ++i) {
        const btVector3 direction = random.direction();
        CHECK(static_cast<double>(found.point.dot(direction)) < reach(b, b_in_a, direction) + bound);
        CHECK(static_cast<double>(on_first.dot(direction)) < reach(a, btTransform::getIdentity(), direction) + bound);
    }
    if (found.distance >= 0.0f) return;
    // No direction overlaps less. Sampled, then walked downhill from the best sample.
    double best = 1e30;
    btVector3 at = found.normal;
    const auto attempt = [&](const btVector3& direction) {
        if (const double depth = -gap(a, b, b_in_a, direction); depth < best) best = depth, at = direction;
    };
    for (int i = 0; i < 400; ++i) attempt(random.direction());
    for (float step = 0.2f; step > 1e-4f; step *= 0.8f)
        for (int i = 0; i < 12; ++i) attempt((at + random.direction() * step).normalized());
    CHECK(-static_cast<double>(found.distance) < best + bound);
}

} // namespace

TEST_CASE("boxes: flush, apart by faces, edges and corners, one in the other, and the same box twice") {
    const auto cube = box(1, 1, 1);
    const auto small = box(0.25f, 0.25f, 0.25f);
    const auto at = [](float x, float y, float z) { return btTransform(btQuaternion::getIdentity(), {x, y, z}); };
    const auto distance = [&](const HullShape& first, const HullShape& second, const btTransform& frame) {
        NearCorners corners;
        return hull_distance(first, second, frame, far_away, corners);
    };
    CHECK(distance(*cube, *cube, at(2, 0, 0)).distance == doctest::Approx(0.0f).epsilon(1e-5));
    CHECK(distance(*cube, *cube, at(3, 0, 0)).distance == doctest::Approx(1.0f));
    CHECK(distance(*cube, *cube, at(3, 3, 0)).distance == doctest::Approx(std::sqrt(2.0f)));
    CHECK(distance(*cube, *cube, at(3, -3, 3)).distance == doctest::Approx(std::sqrt(3.0f)));
    CHECK(distance(*cube, *cube, at(1.5f, 0.1f, 0)).distance == doctest::Approx(-0.5f));
    CHECK(distance(*cube, *cube, at(0, 0, 0)).distance == doctest::Approx(-2.0f));
    CHECK(distance(*cube, *small, at(0, 0.5f, 0)).distance == doctest::Approx(-0.75f));
    const HullDistance flush = distance(*cube, *small, at(0, 0, -1.25f));
    CHECK(flush.distance == doctest::Approx(0.0f).epsilon(1e-5));
    CHECK(flush.normal.z() == doctest::Approx(1.0f));
    CHECK(std::abs(flush.point.z() + 1.0f) < 1e-5f);
}

TEST_CASE("needles, plates and hulls of four points") {
    Random random;
    std::vector<std::unique_ptr<HullShape>> hulls;
    hulls.push_back(box(5.0f, 0.01f, 0.01f));
    hulls.push_back(box(2.0f, 2.0f, 0.001f));
    hulls.push_back(hull_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
    hulls.push_back(hull_of({{0, 0, 0}, {3, 0, 0}, {3, 1e-3f, 0}, {0, 0, 1e-3f}}));
    hulls.push_back(box(0.001f, 0.001f, 0.001f));
    for (const auto& first : hulls)
        for (const auto& second : hulls)
            for (int i = 0; i < 40; ++i) {
                const btTransform frame = random.frame(2.0f);
                NearCorners corners;
                check_certificate(*first, *second, frame, hull_distance(*first, *second, frame, far_away, corners),
                                  random);
            }
}

TEST_CASE("a flat hull and a point have a result") {
    const auto point = hull_of({{0, 0, 0}});
    const auto square = hull_of({{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}});
    NearCorners corners;
    const btTransform above(btQuaternion::getIdentity(), {0, 1, 0}), in(btQuaternion::getIdentity(), {0, 0, 0});
    CHECK(hull_distance(*square, *point, above, far_away, corners).distance == doctest::Approx(1.0f));
    corners = {};
    CHECK(hull_distance(*square, *point, in, far_away, corners).distance == doctest::Approx(0.0f));
    corners = {};
    CHECK(hull_distance(*point, *point, in, far_away, corners).distance == doctest::Approx(0.0f));
}

TEST_CASE(
    "distance and depth of random hulls are certified by their normal and points, and are those that Bullet finds") {
    Random random;
    btVoronoiSimplexSolver simplex;
    btGjkEpaPenetrationDepthSolver penetration;
    int apart = 0, overlapping = 0;
    for (int i = 0; i < 400; ++i) {
        btVector3 radii(0, 0, 0);
        for (int axis = 0; axis < 3; ++axis) radii[axis] = random.number(0.2f, 2);
        const auto first = pebble(8 + static_cast<int>(random.engine() % 25), radii, random);
        const auto second = pebble(8 + static_cast<int>(random.engine() % 25), btVector3(1, 1, 1), random);
        const btTransform frame = random.frame(4.0f);
        NearCorners corners;
        const HullDistance found = hull_distance(*first, *second, frame, far_away, corners);
        check_certificate(*first, *second, frame, found, random);
        (found.distance > 0.0f ? apart : overlapping) += 1;
        if (found.distance <= 0.0f) continue;
        struct Bullets final : btDiscreteCollisionDetectorInterface::Result {
            float distance = -1.0f;
            void setShapeIdentifiersA(int, int) override {}
            void setShapeIdentifiersB(int, int) override {}
            void addContactPoint(const btVector3&, const btVector3&, btScalar depth) override { distance = depth; }
        } bullets;
        btGjkPairDetector gjk(first.get(), second.get(), &simplex, &penetration);
        btGjkPairDetector::ClosestPointInput input;
        input.m_transformA.setIdentity();
        input.m_transformB = frame;
        gjk.getClosestPoints(input, bullets, nullptr);
        CHECK(bullets.distance == doctest::Approx(found.distance).epsilon(1e-3));
    }
    CHECK(apart > 100);
    CHECK(overlapping > 100);
}

TEST_CASE("beginning where it ended gives the same, also after a movement and with corners of other hulls") {
    Random random;
    NearCorners warm;
    for (int i = 0; i < 100; ++i) {
        const auto first = pebble(24, {1, 0.5f, 2}, random), second = pebble(i % 2 ? 32 : 6, {1, 1, 1}, random);
        btTransform frame = random.frame(3.5f);
        for (int step = 0; step < 10; ++step) {
            frame.setOrigin(frame.getOrigin() + random.direction() * 0.02f);
            frame.setRotation(btQuaternion(random.direction(), 0.02f) * frame.getRotation());
            NearCorners cold;
            const float from_cold = hull_distance(*first, *second, frame, far_away, cold).distance;
            const HullDistance from_warm = hull_distance(*first, *second, frame, far_away, warm);
            CHECK(from_warm.distance == doctest::Approx(from_cold).epsilon(2e-4));
            if (step == 0) check_certificate(*first, *second, frame, from_warm, random);
        }
    }
}

TEST_CASE("beyond the limit the distance is a bound, and the normal separates by it") {
    Random random;
    for (int i = 0; i < 300; ++i) {
        const auto first = pebble(20, {1, 0.5f, 1}, random), second = pebble(20, {1, 1, 1}, random);
        const btTransform frame = random.frame(6.0f);
        NearCorners corners, others;
        const float exact = hull_distance(*first, *second, frame, far_away, corners).distance;
        const HullDistance limited = hull_distance(*first, *second, frame, 0.2f, others);
        if (exact <= 0.2f) {
            CHECK(limited.distance == doctest::Approx(exact).epsilon(1e-4));
        } else {
            CHECK(limited.distance > 0.2f);
            CHECK(limited.distance < exact * 1.0001f);
            CHECK(gap(*first, *second, frame, limited.normal) > static_cast<double>(limited.distance) - 1e-5);
        }
    }
}
