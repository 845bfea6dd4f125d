#include "physics/solver/time_of_impact.h"

#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

using namespace brittle::physics;

namespace {

// A cube of 2 m, margin included.
HullShape cube() {
    std::vector<glm::vec3> corners;
    for (const float x : {-0.96f, 0.96f})
        for (const float y : {-0.96f, 0.96f})
            for (const float z : {-0.96f, 0.96f}) corners.emplace_back(x, y, z);
    return {corners, 0.04f};
}

// The time of impact of a moving cube with one that rests at the origin.
std::optional<float> impact(const glm::vec3& from, const Velocity& velocity, float end) {
    const HullShape hull = cube();
    Trajectory moving{.start = {glm::mat3(1.0f), from}, .velocity = velocity, .stop = end}, still;
    moving.find_end();
    still.find_end();
    return time_of_impact({&hull, {}, &moving}, {&hull, {}, &still}, 0.0f, end);
}

} // namespace

TEST_CASE("time of impact: two bodies at rest, apart or in each other, have none but where they overlap too deeply") {
    CHECK_FALSE(impact({0.1f, 5.0f, 0.2f}, {}, 1.0f));
    CHECK_FALSE(impact({0.0f, 2.0f, 0.0f}, {}, 1.0f));                         // flush
    CHECK_FALSE(impact({0.0f, 1.0f, 0.0f}, {}, 1.0f));                         // an overlap that does not grow
    CHECK_FALSE(impact({0.1f, 5.0f, 0.2f}, {{0.0f, -10.0f, 0.0f}, {}}, 0.0f)); // no time
}

TEST_CASE("time of impact: a cube that meets another touches in time, and one that parts, passes or slides does not") {
    const float tolerable = tolerable_depth(cube(), cube());
    CHECK(tolerable == doctest::Approx(0.08));
    for (const float speed : {1.0f, 10.0f, 1000.0f}) {
        CAPTURE(speed);
        const Velocity down{{0.0f, -speed, 0.0f}, {}}, up{{0.0f, speed, 0.0f}, {}}, across{{speed, 0.0f, 0.0f}, {}};
        const auto time = impact({0.1f, 5.0f, 0.2f}, down, 8.0f / speed);
        REQUIRE(time);
        CHECK(*time >= 3.0f / speed);
        CHECK(*time <= (3.0f + 1.01f * tolerable) / speed);            // positions are rounded
        CHECK_FALSE(impact({0.1f, 5.0f, 0.2f}, down, 2.9f / speed));   // too early
        CHECK_FALSE(impact({0.1f, 5.0f, 0.2f}, up, 8.0f / speed));     // they part
        CHECK_FALSE(impact({2.001f, 5.0f, 0.2f}, down, 8.0f / speed)); // passes at a millimetre
        CHECK_FALSE(impact({0.1f, 2.0f, 0.2f}, across, 8.0f / speed)); // slides along the top
    }
}

TEST_CASE("time of impact: a corner that a rotation swings down touches before it is too deep") {
    // At an eighth of a turn the corner reaches down to the square root of two.
    CHECK_FALSE(impact({0, 2.3f, 0}, {{}, {0, 0, 0.1f}}, 1.0f));
    const auto rotated = impact({0, 2.3f, 0}, {{}, {0, 0, 1.0f}}, 0.75f);
    REQUIRE(rotated);
    CHECK(1.0 + std::numbers::sqrt2 * std::sin(0.25 * std::numbers::pi + static_cast<double>(*rotated)) > 2.3);
}

TEST_CASE("time of impact: a trajectory moves freely until it stops, and rests from then on") {
    Trajectory trajectory{.start = {glm::mat3(1.0f), {1.0f, 2.0f, 3.0f}},
                          .velocity = {{2.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}},
                          .stop = 0.5f};
    trajectory.find_end();
    CHECK(trajectory.at(0.25f).origin == glm::vec3(1.5f, 2.0f, 3.0f));
    CHECK(trajectory.at(0.5f) == trajectory.at(2.0f));
    CHECK(trajectory.at(2.0f).origin == glm::vec3(2.0f, 2.0f, 3.0f));
    // The step rotates by 2 atan(w t / 2), slightly less than w t (free_rotation.h).
    CHECK(std::acos(trajectory.at(0.5f).basis[0].x) == doctest::Approx(2.0 * std::atan(0.25)).epsilon(1e-5));
    trajectory.stop = 0.0f;
    trajectory.find_end();
    CHECK(trajectory.at(0.25f) == trajectory.start);
}
