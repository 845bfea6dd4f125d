#include "physics/solver/body.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

glm::vec3 random_vector(test::Random& random, double low, double high) {
    return glm::vec3(random.point(glm::dvec3(low), glm::dvec3(high)));
}

// Bodies of one hull: rotated, moving, with inertia in axes of its own; own and shared hulls, off the centre, too;
// fixed ones and debris.
std::vector<BodyDesc> kinds() {
    test::Random random(11);
    const auto shared = std::make_shared<const CollisionHull>(box_hull(glm::vec3(0.05f)));
    std::vector<BodyDesc> bodies;
    for (int i = 0; i < 300; ++i) {
        const glm::vec3 half = i % 5 == 0 ? random_vector(random, 0.004, 0.009) : random_vector(random, 0.03, 0.09);
        BodyDesc body = box(half, static_cast<float>(random.uniform(0.1, 5.0)), random_vector(random, -1.0, 1.0));
        body.pose.orientation =
            glm::angleAxis(static_cast<float>(random.uniform(0.0, 3.0)), glm::vec3(random.direction()));
        body.linear_velocity = random_vector(random, -1.0, 1.0);
        body.angular_velocity = random_vector(random, -4.0, 4.0);
        const glm::mat3 axes =
            glm::mat3_cast(glm::angleAxis(static_cast<float>(random.uniform(0.0, 3.0)), glm::vec3(random.direction())));
        if (i % 4 != 0) body.inertia = axes * body.inertia * glm::transpose(axes);
        body.friction = static_cast<float>(random.uniform(0.0, 1.0));
        body.restitution = static_cast<float>(random.uniform(0.0, 1.0));
        if (i % 11 == 3) body.hull = {}, body.parts = {{shared, {0.01f, -0.02f, 0.0f}}};
        if (i % 13 == 4) body.fixed = true;
        if (i % 7 == 2) body.debris = true;
        bodies.push_back(body);
    }
    return bodies;
}

NewBody made_of(const BodyDesc& desc, const WorldSettings& settings = {}) {
    Result<NewBody> made = make_body(desc, settings);
    REQUIRE(made.has_value());
    return std::move(*made);
}

double largest_difference(const glm::dmat3& a, const glm::dmat3& b) {
    double most = 0.0;
    for (int column = 0; column < 3; ++column)
        for (int axis = 0; axis < 3; ++axis) most = std::max(most, std::abs(a[column][axis] - b[column][axis]));
    return most;
}

} // namespace

TEST_CASE("body: a new one has the mass, inertia, pose and state of its description") {
    for (const bool sleeping : {true, false}) {
        const WorldSettings settings{.sleeping = sleeping};
        for (const BodyDesc& desc : kinds()) {
            const NewBody made = made_of(desc, settings);
            const Body& body = *made.body;
            CHECK(body.fixed == desc.fixed);
            CHECK(body.mass == desc.mass);
            CHECK(body.inverse_mass == (desc.fixed ? 0.0f : 1.0f / desc.mass));
            CHECK(body.friction == desc.friction);
            CHECK(body.restitution == desc.restitution);
            CHECK(body.velocity.linear == (desc.fixed ? glm::vec3(0.0f) : desc.linear_velocity));
            CHECK(body.velocity.angular == (desc.fixed ? glm::vec3(0.0f) : desc.angular_velocity));
            CHECK(body.activity
                  == (desc.fixed ? Activity::asleep
                      : sleeping ? Activity::awake
                                 : Activity::never_sleeps));
            CHECK(body.awake() == !desc.fixed);
            CHECK(body.debris == (!desc.fixed && (desc.debris || body.longest < settings.debris_size)));
            CHECK(body.frame.origin == desc.pose.position);
            CHECK(body.rewind_frame == body.frame);
            CHECK(body.pose().position == desc.pose.position);
            CHECK(std::abs(glm::dot(body.pose().orientation, desc.pose.orientation)) == doctest::Approx(1.0f));
            if (desc.fixed) {
                CHECK(body.inverse_inertia == glm::mat3(0.0f));
                continue;
            }
            // The description's tensor in world axes, inverted.
            const glm::dmat3 axes = glm::mat3_cast(glm::normalize(glm::dquat(desc.pose.orientation)));
            const glm::dmat3 expected = glm::inverse(axes * glm::dmat3(desc.inertia) * glm::transpose(axes));
            CHECK(largest_difference(glm::dmat3(body.inverse_inertia), expected)
                  < 1e-5 * std::max({expected[0][0], expected[1][1], expected[2][2]}));
        }
    }
}

TEST_CASE("body: the hull's points are where the description has them") {
    for (const BodyDesc& desc : kinds()) {
        const NewBody made = made_of(desc);
        const Body& body = *made.body;
        const CollisionHull& hull = desc.parts.empty() ? desc.hull : *desc.parts[0].hull;
        const glm::vec3 offset = desc.parts.empty() ? glm::vec3(0.0f) : desc.parts[0].offset;
        REQUIRE(body.hull().points().size() == hull.points.size());
        CHECK(body.hull().margin() == hull.margin);
        float reach = 0.0f;
        for (size_t i = 0; i < hull.points.size(); ++i) {
            const glm::vec3 at = desc.pose.position + desc.pose.orientation * (hull.points[i] + offset);
            CHECK(glm::length(body.frame * body.hull().points()[i] - at) < 1e-6f);
            reach = std::max(reach, glm::length(hull.points[i] + offset) + hull.margin);
        }
        CHECK(body.reach == doctest::Approx(reach));
        CHECK(body.longest == body.hull().longest());
        CHECK(body.thickness == doctest::Approx(hull.margin / HullSettings{}.margin_fraction));
    }
}

TEST_CASE("body: the bounds of a new one hold it") {
    for (const BodyDesc& desc : kinds()) {
        const NewBody made = made_of(desc);
        const Body& body = *made.body;
        const SweptProxy& proxy = *made.proxy;
        CHECK(body.proxy == &proxy);
        CHECK(proxy.body == &body);
        const Bounds bounds = body.bounds(body.frame);
        const float slack = body.fixed ? 0.0f : 1e-5f * body.reach, most = 2.00001f * body.reach;
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(proxy.bounds.low[axis] <= bounds.low[axis] + slack);
            CHECK(proxy.bounds.high[axis] >= bounds.high[axis] - slack);
            CHECK(proxy.bounds.high[axis] - proxy.bounds.low[axis] <= most + 1e-6f * glm::length(proxy.bounds.high));
        }
        CHECK(proxy.fixed == body.fixed);
    }
}

TEST_CASE("body: kinetic energy and momenta are those of its description") {
    for (const BodyDesc& desc : kinds()) {
        const NewBody made = made_of(desc);
        const Mechanics found = mechanics_of(*made.body, {0.0f, -9.81f, 0.0f});
        if (desc.fixed) {
            CHECK(found.kinetic == 0.0);
            CHECK(found.momentum == glm::dvec3(0.0));
            continue;
        }
        const glm::dmat3 axes = glm::mat3_cast(glm::normalize(glm::dquat(desc.pose.orientation)));
        const glm::dvec3 spin =
            axes * glm::dmat3(desc.inertia) * glm::transpose(axes) * glm::dvec3(desc.angular_velocity);
        const auto mass = static_cast<double>(desc.mass);
        const glm::dvec3 momentum = mass * glm::dvec3(desc.linear_velocity);
        const double kinetic = 0.5 * glm::dot(momentum, glm::dvec3(desc.linear_velocity))
                               + 0.5 * glm::dot(spin, glm::dvec3(desc.angular_velocity));
        CHECK(found.kinetic == doctest::Approx(kinetic).epsilon(1e-5));
        CHECK(found.potential
              == doctest::Approx(mass * 9.81 * static_cast<double>(desc.pose.position.y)).epsilon(1e-5));
        CHECK(glm::length(found.momentum - momentum) < 1e-6 * glm::length(momentum));
        const glm::dvec3 angular = spin + glm::cross(glm::dvec3(desc.pose.position), momentum);
        CHECK(glm::length(found.angular_momentum - angular) < 1e-5 * (glm::length(angular) + glm::length(momentum)));
    }
}

TEST_CASE("body: neither a body that never sleeps nor one that is astray changes its activity") {
    for (const Activity activity : {Activity::never_sleeps, Activity::astray}) {
        const NewBody made = made_of(box(glm::vec3(0.1f), 1.0f, {}));
        made.body->activity = activity;
        for (const Activity to : {Activity::awake, Activity::ready, Activity::asleep}) made.body->set_activity(to);
        CHECK(made.body->activity == activity);
        CHECK(made.body->awake() == (activity == Activity::never_sleeps));
    }
}
