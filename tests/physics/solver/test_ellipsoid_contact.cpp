#include "physics/solver/ellipsoid_contact.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "physics/solver/body.h"
#include "physics/solver/manifold.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

std::unique_ptr<Body> body_of(BodyDesc desc) {
    desc.debris = true;
    Result<NewBody> made = make_body(desc, {});
    REQUIRE(made.has_value());
    return std::move(made->body);
}

// The contact of two bodies at rest; without one, a count of zero.
EllipsoidManifold contact_of(const Body& a, const Body& b) {
    const std::unique_ptr<PairContacts> contacts = make_ellipsoid_contacts(a, b);
    contacts->update({.seconds = 1.0f / 120.0f, .gravity = -9.81f});
    std::vector<AnyManifold> found;
    contacts->collect(found);
    return found.empty() ? EllipsoidManifold{} : *found[0].ellipsoids;
}

// The support of a body's ellipsoid, in double precision.
double support_of(const Body& body, const glm::dvec3& direction) {
    double sum = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double along = glm::dot(direction, glm::dvec3(body.frame.basis[axis]));
        sum += along * along * static_cast<double>(body.squared_semi_axes[axis]);
    }
    return std::sqrt(sum);
}

double distance_along(const Body& a, const Body& b, const glm::dvec3& direction) {
    return glm::dot(direction, glm::dvec3(a.frame.origin) - glm::dvec3(b.frame.origin)) - support_of(a, direction)
           - support_of(b, direction);
}

} // namespace

TEST_CASE("ellipsoid: its proportions are those of the bounds, and its volume that of the hull") {
    CHECK(squared_semi_axes({}, 0.0f) == glm::vec3(0.0f));
    const glm::vec3 flat = squared_semi_axes({{-1, -1, -0.0f}, {1, 1, 0.0f}}, 0.0f);
    CHECK(flat.z == 0.0f);
    CHECK(std::isfinite(flat.x));
    const Bounds box{{-1, -2, -3}, {1, 2, 3}};
    const glm::vec3 axes = glm::sqrt(squared_semi_axes(box, 48.0f));
    CHECK(axes.y == doctest::Approx(2.0f * axes.x));
    CHECK(axes.z == doctest::Approx(3.0f * axes.x));
    const float volume = 4.1887902f * axes.x * axes.y * axes.z;
    CHECK(volume <= 48.0f);
    CHECK(volume > 0.8f * 48.0f);
    for (const float thin : {1e-6f, 1e6f}) { // bounded by the box
        const glm::vec3 of_thin = glm::sqrt(squared_semi_axes(box, thin));
        CHECK(of_thin.x >= 0.4f);
        CHECK(of_thin.x <= 1.25f);
    }
}

TEST_CASE("ellipsoid: bodies touch as ellipsoids if one is debris, both move and their sizes are similar") {
    const auto made = [](float half, bool debris, bool fixed) {
        BodyDesc desc = box(glm::vec3(half), 1.0f, {});
        desc.debris = debris;
        desc.fixed = fixed;
        return std::move(make_body(desc, {})->body);
    };
    const auto debris = made(0.1f, true, false), moving = made(0.1f, false, false), fixed = made(0.1f, false, true),
               large = made(0.2f, false, false), large_debris = made(0.2f, true, false);
    CHECK(touch_as_ellipsoids(*debris, *debris));
    CHECK(touch_as_ellipsoids(*debris, *moving));
    CHECK(touch_as_ellipsoids(*moving, *debris));
    CHECK_FALSE(touch_as_ellipsoids(*moving, *moving));
    CHECK_FALSE(touch_as_ellipsoids(*debris, *fixed));
    CHECK_FALSE(touch_as_ellipsoids(*debris, *large));
    CHECK_FALSE(touch_as_ellipsoids(*large_debris, *debris));
}

TEST_CASE("ellipsoid: bodies in one place have a contact that is finite") {
    const auto a = body_of(block(glm::vec3(0.0f))), b = body_of(block(glm::vec3(0.0f)));
    const EllipsoidManifold contact = contact_of(*a, *b);
    REQUIRE(contact.count == 1);
    CHECK(glm::length(contact.point.normal) == doctest::Approx(1.0f));
    CHECK(contact.point.distance < -block_half);
    CHECK(std::isfinite(contact.point.position.x));
}

TEST_CASE("ellipsoid: the distance is that along the normal, and close to the greatest along any direction") {
    test::Random random(4);
    int found = 0;
    for (int trial = 0; trial < 300; ++trial) {
        CAPTURE(trial);
        const auto one = [&](const glm::vec3& at) {
            BodyDesc desc = box(glm::vec3(random.point(glm::dvec3(0.03), glm::dvec3(0.08))), 1.0f, at);
            desc.pose.orientation =
                glm::angleAxis(static_cast<float>(random.uniform(0.0, 3.0)), glm::vec3(random.direction()));
            return body_of(desc);
        };
        const auto a = one(glm::vec3(random.direction()) * 0.11f), b = one(glm::vec3(0.0f));
        const EllipsoidManifold contact = contact_of(*a, *b);
        double best = -1.0;
        glm::dvec3 normal(0.0);
        for (int i = 0; i < 4000; ++i) {
            const glm::dvec3 direction = random.direction();
            if (const double distance = distance_along(*a, *b, direction); distance > best)
                best = distance, normal = direction;
        }
        if (contact.count == 0) {
            CHECK(best > -1e-3); // apart
            continue;
        }
        ++found;
        const auto distance = static_cast<double>(contact.point.distance);
        CHECK(std::abs(distance - distance_along(*a, *b, glm::dvec3(contact.point.normal))) < 1e-5);
        CHECK(distance > best - 3e-3);
        CHECK(distance < best + 1e-3); // beyond what the sampled directions missed
    }
    CHECK(found > 100);
}

TEST_CASE("ellipsoid: a fast body has a contact ahead if it will touch, and none if it passes") {
    const auto target = body_of(block(glm::vec3(0.0f)));
    for (const bool meets : {true, false}) {
        const auto flies = body_of(block({-0.5f, meets ? 0.0f : 0.2f, 0.0f}));
        flies->velocity.linear = {100.0f, 0.0f, 0.0f}; // 0.83 m in a step
        const EllipsoidManifold contact = contact_of(*flies, *target);
        CHECK(contact.count == (meets ? 1 : 0));
        if (!meets) continue;
        CHECK(contact.point.normal.x < -0.99f);
        CHECK(contact.point.distance > 0.3f);
    }
}
