// What a view shows, without a device: against points that are projected, and against distances to the sides of a pyramid.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "engine/render/view_volume.h"

using namespace brittle::engine;

namespace {

struct Random {
    std::mt19937 engine{17};

    float between(float low, float high) { return low + (high - low) * static_cast<float>(engine() >> 8) * 0x1p-24f; }
    glm::vec3 vector(float size) { return {between(-size, size), between(-size, size), between(-size, size)}; }
    glm::vec3 direction() {
        for (;;)
            if (const glm::vec3 v = vector(1.0f); glm::length(v) > 0.1f && glm::length(v) < 1.0f)
                return glm::normalize(v);
    }
};

// Where the view's pyramid, which begins in the eye, has its sides: how far outside of the nearest one a place is, in
// metres; negative: inside of all. In doubles, from the angles.
double outside(const Camera& camera, float aspect, const glm::vec3& place) {
    const glm::dvec3 forward = glm::normalize(glm::dvec3(camera.target) - glm::dvec3(camera.eye));
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0.0, 1.0, 0.0))),
                     up = glm::cross(right, forward);
    const glm::dvec3 way = glm::dvec3(place) - glm::dvec3(camera.eye);
    const double depth = glm::dot(way, forward), high = 0.5 * double{camera.vertical_fov};
    const double wide = std::atan(double{aspect} * std::tan(high));
    const double sideways = std::abs(glm::dot(way, right)) * std::cos(wide) - depth * std::sin(wide);
    const double upwards = std::abs(glm::dot(way, up)) * std::cos(high) - depth * std::sin(high);
    return std::max({sideways, upwards, -depth});
}

} // namespace

TEST_CASE("view volume: any camera, and things that are no ball, have an answer") {
    const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    for (const Camera& camera :
         {Camera{{1, 1, 1}, {1, 1, 1}}, Camera{{0, 5, 0}, {0, 0, 0}}, Camera{{nan, 0, 0}, {}},
          Camera{{0, 0, 1}, {inf, 0, 0}}, Camera{{0, 0, 1}, {}, 0.0f}, Camera{{0, 0, 1}, {}, nan}})
        for (const float aspect : {0.0f, 1.5f})
            CHECK(ViewVolume(camera, aspect).sees(camera.eye, 1.0f)); // around the eye
    const ViewVolume view({.eye = {0, 0, 5}, .target = {}}, 1.5f);
    CHECK(view.sees({nan, 0, 0}, 0.0f)); // rather than to lose something that is there
    CHECK(view.sees({0, 0, 0}, 0.0f));
    CHECK_FALSE(view.sees({0, 0, 6}, 0.0f));
}

TEST_CASE("view volume: from the eye to any depth") {
    const ViewVolume view({.eye = {0, 0, 5}, .target = {}}, 1.5f);
    for (const float depth : {1e-3f, 0.1f, 10.0f, 1e3f, 1e5f}) CHECK(view.sees({0, 0, 5.0f - depth}, 0.0f));
    CHECK_FALSE(view.sees({0, 0, 1e3f}, 1.0f));
    CHECK(view.sees({0, 0, 1e3f}, 1e3f)); // reaches around the eye
}

TEST_CASE("view volume: a shift moves what is in the middle") {
    const Camera camera{.eye = {0, 0, 5}, .target = {}, .shift = {0.8f, 0.0f}};
    const ViewVolume view(camera, 1.0f);
    const float side = 5.0f * std::tan(0.5f * camera.vertical_fov); // of half a picture, at the target
    CHECK(view.sees({0.15f * side, 0, 0}, 0.0f));
    CHECK_FALSE(view.sees({0.25f * side, 0, 0}, 0.0f));
    CHECK(view.sees({-1.75f * side, 0, 0}, 0.0f));
    CHECK_FALSE(view.sees({-1.85f * side, 0, 0}, 0.0f));
}

TEST_CASE("view volume: a ball is seen where any of it is, and not where it is outside of one side") {
    Random random;
    int seen = 0, unseen = 0;
    for (int round = 0; round < 4000; ++round) {
        const Camera camera{
            .eye = random.vector(5.0f), .target = random.vector(5.0f), .vertical_fov = random.between(0.05f, 2.0f)};
        const glm::vec3 way = camera.target - camera.eye;
        if (std::abs(way.y) > 0.99f * glm::length(way)) continue; // where up is another one
        const float aspect = random.between(0.3f, 3.0f), radius = random.between(0.0f, 1.0f);
        const ViewVolume view(camera, aspect);
        const glm::vec3 from = random.vector(8.0f), to = round % 2 ? from : random.vector(8.0f);
        const bool sees = view.sees(from, to, radius);
        CAPTURE(round);
        for (int point = 0; point < 20; ++point) { // of the ball on its way
            const glm::vec3 place =
                from + random.between(0.0f, 1.0f) * (to - from) + random.between(0.0f, radius) * random.direction();
            if (outside(camera, aspect, place) < 0.0) REQUIRE(sees);
        }
        // Of a ball, the side that it is farthest outside of says it: that which the greatest of the distances is for.
        if (from == to) {
            const double away = outside(camera, aspect, from);
            if (away > double{radius} * 1.01 + 1e-3) REQUIRE_FALSE(sees);
            if (away < double{radius}) REQUIRE(sees);
        }
        ++(sees ? seen : unseen);
    }
    CHECK(seen > 500);
    CHECK(unseen > 500);
}
