#include "physics/solver/hull_distance.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <random>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

using namespace brittle::physics;

namespace {

constexpr float far_away = 1e6f; // a limit beyond every distance here

struct Random {
    std::mt19937 engine{11};
    float number(float low, float high) { return low + (high - low) * static_cast<float>(engine() >> 8) / 16777216.0f; }
    glm::vec3 direction() {
        glm::vec3 v(0.0f);
        do
            for (int axis = 0; axis < 3; ++axis) v[axis] = number(-1, 1);
        while (length_squared(v) > 1.0f || length_squared(v) < 0.01f);
        return glm::normalize(v);
    }
    Transform frame(float space) {
        const glm::vec3 axis = direction(), away = direction();
        const float angle = number(0, 6);
        return {matrix_of(glm::angleAxis(angle, axis)), away * number(0, space)};
    }
};

HullShape hull_of(std::vector<glm::vec3> points) {
    return {std::move(points), 0.0f};
}
HullShape box(float x, float y, float z) {
    std::vector<glm::vec3> points;
    for (int i = 0; i < 8; ++i) points.emplace_back(i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z);
    return hull_of(std::move(points));
}
// Points on an ellipsoid.
HullShape pebble(int count, const glm::vec3& radii, Random& random) {
    std::vector<glm::vec3> points;
    for (int i = 0; i < count; ++i) points.push_back(random.direction() * radii);
    return hull_of(std::move(points));
}
Transform at(float x, float y, float z) {
    return {glm::mat3(1.0f), {x, y, z}};
}

double support_of(const HullShape& hull, const Transform& frame, const glm::vec3& direction) {
    double most = -1e30;
    for (const glm::vec3& point : hull.points())
        most = std::max(most, static_cast<double>(glm::dot(frame * point, direction)));
    return most;
}
// The gap between the hulls along a direction from the second to the first; below 0: their overlap along it.
double gap(const HullShape& a, const HullShape& b, const Transform& b_in_a, const glm::vec3& direction) {
    return -support_of(a, {}, -direction) - support_of(b, b_in_a, direction);
}

// A distance is right if the normal separates the hulls by it, so that the hulls are no nearer, and if the two points
// lie in their hulls, so that the hulls are no farther. Random directions test whether a point lies in a hull.
void check_certificate(const HullShape& a, const HullShape& b, const Transform& b_in_a, const HullDistance& found,
                       Random& random) {
    // Positions are rounded to 1e-7 of the coordinates, so a small hull far from the first one's origin is less exact.
    const double bound =
        3e-5 * static_cast<double>(a.radius() + b.radius()) + 4e-7 * static_cast<double>(glm::length(b_in_a.origin));
    CHECK(std::abs(glm::length(found.normal) - 1.0f) < 1e-5f);
    CHECK(std::abs(gap(a, b, b_in_a, found.normal) - static_cast<double>(found.distance)) < bound);
    const glm::vec3 on_first = found.point + found.normal * found.distance;
    for (int i = 0; i < 60; ++i) {
        const glm::vec3 direction = random.direction();
        CHECK(static_cast<double>(glm::dot(found.point, direction)) < support_of(b, b_in_a, direction) + bound);
        CHECK(static_cast<double>(glm::dot(on_first, direction)) < support_of(a, {}, direction) + bound);
    }
    if (found.distance >= 0.0f) return;
    // No direction has less overlap: random samples, then a random walk downhill from the best one.
    double best = 1e30;
    glm::vec3 best_direction = found.normal;
    const auto attempt = [&](const glm::vec3& direction) {
        if (const double depth = -gap(a, b, b_in_a, direction); depth < best) best = depth, best_direction = direction;
    };
    for (int i = 0; i < 400; ++i) attempt(random.direction());
    for (float step = 0.2f; step > 1e-4f; step *= 0.8f)
        for (int i = 0; i < 12; ++i) attempt(glm::normalize(best_direction + random.direction() * step));
    CHECK(-static_cast<double>(found.distance) < best + bound);
}

// The exact answer by exhaustion, in double. Every triangle, segment and corner of a hull's points lies in the hull,
// and the nearest points lie on a corner and a triangle or on two segments. The least overlap of two hulls is along the
// normal of a triangle or along the cross product of two segments.
class Exhaustive {
  public:
    Exhaustive(const HullShape& a, const HullShape& b, const Transform& b_in_a) {
        for (const glm::vec3& point : a.points()) a_.emplace_back(point);
        for (const glm::vec3& point : b.points()) b_.emplace_back(b_in_a * point);
        corners_and_triangles(a_, b_);
        corners_and_triangles(b_, a_);
        for (size_t i = 0; i < a_.size(); ++i)
            for (size_t j = 0; j < i; ++j)
                for (size_t k = 0; k < b_.size(); ++k)
                    for (size_t l = 0; l < k; ++l) segments(a_[i], a_[j], b_[k], b_[l]);
    }
    [[nodiscard]] double distance() const { return overlap_ > 0.0 ? -overlap_ : nearest_; }

  private:
    using Points = std::vector<glm::dvec3>;

    void try_direction(const glm::dvec3& normal) {
        const double length = glm::length(normal);
        if (length < 1e-9) return;
        double low_a = 1e30, high_a = -1e30, low_b = 1e30, high_b = -1e30;
        for (const glm::dvec3& p : a_) {
            low_a = std::min(low_a, glm::dot(p, normal));
            high_a = std::max(high_a, glm::dot(p, normal));
        }
        for (const glm::dvec3& p : b_) {
            low_b = std::min(low_b, glm::dot(p, normal));
            high_b = std::max(high_b, glm::dot(p, normal));
        }
        overlap_ = std::min(overlap_, std::min(high_a - low_b, high_b - low_a) / length);
    }
    void corners_and_triangles(const Points& corners, const Points& of) {
        for (size_t i = 0; i < of.size(); ++i)
            for (size_t j = 0; j < i; ++j)
                for (size_t k = 0; k < j; ++k) {
                    const glm::dvec3 &a = of[i], &b = of[j], &c = of[k], normal = glm::cross(b - a, c - a);
                    try_direction(normal);
                    for (const glm::dvec3& p : corners)
                        if (glm::dot(normal, glm::cross(b - a, p - a)) >= 0.0
                            && glm::dot(normal, glm::cross(c - b, p - b)) >= 0.0
                            && glm::dot(normal, glm::cross(a - c, p - c)) >= 0.0)
                            nearest_ = std::min(nearest_, std::abs(glm::dot(normal, p - a)) / glm::length(normal));
                }
    }
    // C. Ericson, "Real-Time Collision Detection", 2004, 5.1.9.
    void segments(const glm::dvec3& p, const glm::dvec3& to_p, const glm::dvec3& q, const glm::dvec3& to_q) {
        const glm::dvec3 u = to_p - p, v = to_q - q, r = p - q;
        try_direction(glm::cross(u, v));
        const double a = glm::dot(u, u), e = glm::dot(v, v), f = glm::dot(v, r), c = glm::dot(u, r), b = glm::dot(u, v);
        const double denominator = a * e - b * b;
        double s = denominator > 1e-12 ? std::clamp((b * f - c * e) / denominator, 0.0, 1.0) : 0.0;
        const double t = std::clamp((b * s + f) / e, 0.0, 1.0);
        s = std::clamp((b * t - c) / a, 0.0, 1.0);
        nearest_ = std::min(nearest_, glm::length((p + s * u) - (q + t * v)));
    }

    Points a_, b_;
    double nearest_ = 1e30, overlap_ = 1e30;
};

} // namespace

TEST_CASE("hull distance: boxes apart by faces, edges and corners, touching, nested, and a box with itself") {
    const HullShape cube = box(1, 1, 1), small = box(0.25f, 0.25f, 0.25f);
    const auto distance = [&](const HullShape& first, const HullShape& second, const Transform& frame) {
        NearestCorners corners;
        return hull_distance(first, second, frame, far_away, corners);
    };
    CHECK(distance(cube, cube, at(2, 0, 0)).distance == doctest::Approx(0.0f).epsilon(1e-5));
    CHECK(distance(cube, cube, at(3, 0, 0)).distance == doctest::Approx(1.0f));
    CHECK(distance(cube, cube, at(3, 3, 0)).distance == doctest::Approx(std::sqrt(2.0f)));
    CHECK(distance(cube, cube, at(3, -3, 3)).distance == doctest::Approx(std::sqrt(3.0f)));
    CHECK(distance(cube, cube, at(1.5f, 0.1f, 0)).distance == doctest::Approx(-0.5f));
    CHECK(distance(cube, cube, at(0, 0, 0)).distance == doctest::Approx(-2.0f));
    CHECK(distance(cube, small, at(0, 0.5f, 0)).distance == doctest::Approx(-0.75f));
    const HullDistance flush = distance(cube, small, at(0, 0, -1.25f));
    CHECK(flush.distance == doctest::Approx(0.0f).epsilon(1e-5));
    CHECK(flush.normal.z == doctest::Approx(1.0f));
    CHECK(std::abs(flush.point.z + 1.0f) < 1e-5f);
}

TEST_CASE("hull distance: needles, plates and tetrahedra") {
    Random random;
    const std::vector<HullShape> hulls{
        box(5.0f, 0.01f, 0.01f), box(2.0f, 2.0f, 0.001f), hull_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}),
        hull_of({{0, 0, 0}, {3, 0, 0}, {3, 1e-3f, 0}, {0, 0, 1e-3f}}), box(0.001f, 0.001f, 0.001f)};
    for (const HullShape& first : hulls)
        for (const HullShape& second : hulls)
            for (int i = 0; i < 40; ++i) {
                const Transform frame = random.frame(2.0f);
                NearestCorners corners;
                check_certificate(first, second, frame, hull_distance(first, second, frame, far_away, corners), random);
            }
}

TEST_CASE("hull distance: a flat hull and a single point have a result") {
    const HullShape point = hull_of({{0, 0, 0}}), square = hull_of({{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}});
    NearestCorners corners;
    CHECK(hull_distance(square, point, at(0, 1, 0), far_away, corners).distance == doctest::Approx(1.0f));
    corners = {};
    CHECK(hull_distance(square, point, {}, far_away, corners).distance == doctest::Approx(0.0f));
    corners = {};
    CHECK(hull_distance(point, point, {}, far_away, corners).distance == doctest::Approx(0.0f));
}

TEST_CASE("hull distance: normal and points certify distance and depth of random hulls") {
    Random random;
    int apart = 0, overlapping = 0;
    for (int i = 0; i < 400; ++i) {
        glm::vec3 radii;
        for (int axis = 0; axis < 3; ++axis) radii[axis] = random.number(0.2f, 2);
        const HullShape first = pebble(8 + static_cast<int>(random.engine() % 25), radii, random);
        const HullShape second = pebble(8 + static_cast<int>(random.engine() % 25), glm::vec3(1.0f), random);
        const Transform frame = random.frame(4.0f);
        NearestCorners corners;
        const HullDistance found = hull_distance(first, second, frame, far_away, corners);
        check_certificate(first, second, frame, found, random);
        (found.distance > 0.0f ? apart : overlapping) += 1;
    }
    CHECK(apart > 100);
    CHECK(overlapping > 100);
}

TEST_CASE(
    "hull distance: distance and depth of random hulls match an exhaustive search over corners, edges and faces") {
    Random random;
    int apart = 0, overlapping = 0;
    for (int i = 0; i < 300; ++i) {
        CAPTURE(i);
        glm::vec3 radii;
        for (int axis = 0; axis < 3; ++axis) radii[axis] = random.number(0.2f, 2);
        const HullShape first = pebble(4 + static_cast<int>(random.engine() % 7), radii, random);
        const HullShape second = pebble(4 + static_cast<int>(random.engine() % 7), glm::vec3(1.0f), random);
        const Transform frame = random.frame(3.5f);
        NearestCorners corners;
        const float found = hull_distance(first, second, frame, far_away, corners).distance;
        CHECK(std::abs(static_cast<double>(found) - Exhaustive(first, second, frame).distance()) < 1e-5);
        (found > 0.0f ? apart : overlapping) += 1;
    }
    CHECK(apart > 80);
    CHECK(overlapping > 80);
}

TEST_CASE("hull distance: a warm start gives the cold result, after a movement and with corners of other hulls") {
    Random random;
    NearestCorners warm;
    for (int i = 0; i < 100; ++i) {
        const HullShape first = pebble(24, {1, 0.5f, 2}, random), second = pebble(i % 2 ? 32 : 6, {1, 1, 1}, random);
        Transform frame = random.frame(3.5f);
        for (int step = 0; step < 10; ++step) {
            frame.origin += random.direction() * 0.02f;
            frame.basis = matrix_of(glm::angleAxis(0.02f, random.direction()) * rotation_of(frame.basis));
            NearestCorners cold;
            const float from_cold = hull_distance(first, second, frame, far_away, cold).distance;
            const HullDistance from_warm = hull_distance(first, second, frame, far_away, warm);
            CHECK(from_warm.distance == doctest::Approx(from_cold).epsilon(2e-4));
            if (step == 0) check_certificate(first, second, frame, from_warm, random);
        }
    }
}

TEST_CASE("hull distance: beyond the limit the distance is a lower bound, and the normal separates by it") {
    Random random;
    for (int i = 0; i < 300; ++i) {
        const HullShape first = pebble(20, {1, 0.5f, 1}, random), second = pebble(20, {1, 1, 1}, random);
        const Transform frame = random.frame(6.0f);
        NearestCorners corners, others;
        const float exact = hull_distance(first, second, frame, far_away, corners).distance;
        const HullDistance limited = hull_distance(first, second, frame, 0.2f, others);
        if (exact <= 0.2f) {
            CHECK(limited.distance == doctest::Approx(exact).epsilon(1e-4));
        } else {
            CHECK(limited.distance > 0.2f);
            CHECK(limited.distance < exact * 1.0001f);
            CHECK(gap(first, second, frame, limited.normal) > static_cast<double>(limited.distance) - 1e-5);
        }
    }
}
