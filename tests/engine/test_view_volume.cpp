// ViewVolume, without a device, compared with projected points and with distances to the sides of the view pyramid.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "engine/camera/view_volume.h"

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

// Returns the largest signed distance of a place, in metres, from the sides of the view pyramid, whose apex is the eye:
// positive outside a side, negative inside all. Computed in doubles from the angles.
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

TEST_CASE("view volume: every camera and degenerate ball has an answer") {
    const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    for (const Camera& camera :
         {Camera{{1, 1, 1}, {1, 1, 1}}, Camera{{0, 5, 0}, {0, 0, 0}}, Camera{{nan, 0, 0}, {}},
          Camera{{0, 0, 1}, {inf, 0, 0}}, Camera{{0, 0, 1}, {}, 0.0f}, Camera{{0, 0, 1}, {}, nan}})
        for (const float aspect : {0.0f, 1.5f})
            CHECK(ViewVolume(camera, aspect).sees(camera.eye, 1.0f)); // a ball around the eye
    const ViewVolume view({.eye = {0, 0, 5}, .target = {}}, 1.5f);
    CHECK(view.sees({nan, 0, 0}, 0.0f)); // conservative: accepted
    CHECK(view.sees({0, 0, 0}, 0.0f));
    CHECK_FALSE(view.sees({0, 0, 6}, 0.0f));
}

TEST_CASE("view volume: it begins at the eye and its depth is unlimited") {
    const ViewVolume view({.eye = {0, 0, 5}, .target = {}}, 1.5f);
    for (const float depth : {1e-3f, 0.1f, 10.0f, 1e3f, 1e5f}) CHECK(view.sees({0, 0, 5.0f - depth}, 0.0f));
    CHECK_FALSE(view.sees({0, 0, 1e3f}, 1.0f));
    CHECK(view.sees({0, 0, 1e3f}, 1e3f)); // reaches around the eye
}

TEST_CASE("view volume: Camera::shift moves the centre") {
    const Camera camera{.eye = {0, 0, 5}, .target = {}, .shift = {0.8f, 0.0f}};
    const ViewVolume view(camera, 1.0f);
    const float side = 5.0f * std::tan(0.5f * camera.vertical_fov); // half the picture's height at the target
    CHECK(view.sees({0.15f * side, 0, 0}, 0.0f));
    CHECK_FALSE(view.sees({0.25f * side, 0, 0}, 0.0f));
    CHECK(view.sees({-1.75f * side, 0, 0}, 0.0f));
    CHECK_FALSE(view.sees({-1.85f * side, 0, 0}, 0.0f));
}

TEST_CASE("view volume: a ball is visible if any part of it is, and not if it is outside one side") {
    Random random;
    int seen = 0, unseen = 0;
    for (int round = 0; round < 4000; ++round) {
        const Camera camera{
            .eye = random.vector(5.0f), .target = random.vector(5.0f), .vertical_fov = random.between(0.05f, 2.0f)};
        const glm::vec3 way = camera.target - camera.eye;
        if (std::abs(way.y) > 0.99f * glm::length(way)) continue; // these views have another up axis
        const float aspect = random.between(0.3f, 3.0f), radius = random.between(0.0f, 1.0f);
        const ViewVolume view(camera, aspect);
        const glm::vec3 from = random.vector(8.0f), to = round % 2 ? from : random.vector(8.0f);
        const bool sees = view.sees(from, to, radius);
        CAPTURE(round);
        for (int point = 0; point < 20; ++point) { // points of the moving ball
            const glm::vec3 place =
                from + random.between(0.0f, 1.0f) * (to - from) + random.between(0.0f, radius) * random.direction();
            if (outside(camera, aspect, place) < 0.0) REQUIRE(sees);
        }
        // A ball is outside if its distance from any side, hence the largest distance, exceeds its radius.
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
