// Rows of contacts with the ground: four at a time equal each made alone from the equations of row.h, bit for bit.
#include "physics/solver/ground_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "physics/solver/transform.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

// J along a direction at a point, J M^-1 J^T and J v.
struct OneRow {
    glm::vec3 along{0.0f}, angular{0.0f}, inverse_inertia_angular{0.0f};
    float response = 0.0f, apart = 0.0f;
};

OneRow row_of(const glm::vec3& along, const glm::vec3& at, const SolverBody& body) {
    OneRow row{.along = along, .angular = glm::cross(at - body.centre, along)};
    row.inverse_inertia_angular = {glm::dot(body.inverse_inertia[0], row.angular),
                                   glm::dot(body.inverse_inertia[1], row.angular),
                                   glm::dot(body.inverse_inertia[2], row.angular)};
    row.response = body.inverse_mass + glm::dot(row.inverse_inertia_angular, row.angular);
    row.apart = glm::dot(along, body.linear) + glm::dot(row.angular, body.angular);
    return row;
}

void check_lane(const std::array<Four, 3>& lanes, size_t lane, const glm::vec3& expected) {
    for (size_t axis = 0; axis < 3; ++axis) CHECK(lanes[axis][lane] == expected[static_cast<int>(axis)]);
}

void check_friction(const FourFrictions& rows, size_t lane, size_t k, const OneRow& expected, float impulse) {
    const FourFrictions::Along& found = rows.along[k];
    check_lane(found.tangent, lane, expected.along);
    check_lane(found.angular, lane, expected.angular);
    check_lane(found.inverse_inertia_angular, lane, expected.inverse_inertia_angular);
    CHECK(found.rest[lane] == -expected.apart);
    CHECK(found.impulse[lane] == impulse);
    CHECK(found.total[lane] == 0.0f);
}

void check_point(const GroundRows& rows, size_t lane, const SolverBody& body, const GroundManifold& ground,
                 size_t index, const GroundStep& step) {
    const GroundPoint& point = ground.all[index];
    const glm::vec3 at = point.position, up(0, 1, 0);
    const OneRow contact = row_of(up, at, body);
    const float mass = 1.0f / contact.response, approach = -contact.apart;
    float bounce = 0.0f;
    if (approach >= step.min_bounce_speed && approach > 0.0f) bounce = approach * ground.restitution;
    check_lane(rows.contacts.normal, lane, up);
    check_lane(rows.contacts.angular, lane, contact.angular);
    check_lane(rows.contacts.inverse_inertia_angular, lane, contact.inverse_inertia_angular);
    CHECK(rows.contacts.rest[lane] == approach * mass);
    CHECK(rows.contacts.effective_mass[lane] == mass);
    CHECK(rows.contacts.gap[lane] == point.distance);
    CHECK(rows.contacts.slop[lane] == ground.slop);
    CHECK(rows.contacts.share[lane] == body.share);
    CHECK(rows.contacts.bounce[lane] == bounce * mass);
    CHECK(rows.contacts.impulse[lane] == point.start.normal);
    CHECK(rows.contacts.total[lane] == 0.0f);
    CHECK(rows.contacts.start[lane] == point.start.normal);
    CHECK(rows.contacts.bias[lane] == 0.0f); // set by each substep
    CHECK(rows.speed[lane] == approach);

    const Tangents& tangents = tangents_of_ground();
    const OneRow first = row_of(tangents.first, at, body), second = row_of(tangents.second, at, body);
    check_friction(rows.frictions, lane, 0, first, glm::dot(tangents.first, point.start.friction));
    check_friction(rows.frictions, lane, 1, second, glm::dot(tangents.second, point.start.friction));
    const float between = glm::dot(first.inverse_inertia_angular, second.angular);
    const float inverse = 1.0f / (first.response * second.response - between * between);
    CHECK(rows.frictions.mass_11[lane] == second.response * inverse);
    CHECK(rows.frictions.mass_12[lane] == -between * inverse);
    CHECK(rows.frictions.mass_22[lane] == first.response * inverse);
    CHECK(rows.frictions.sliding_mass[lane] == 1.0f / (first.response + second.response));
}

// A row of zeros changes no velocity and takes no impulse.
void check_zero(const GroundRows& rows, size_t lane) {
    const FourRows& contact = rows.contacts;
    const glm::vec3 none(0.0f);
    check_lane(contact.normal, lane, none);
    check_lane(contact.angular, lane, none);
    check_lane(contact.inverse_inertia_angular, lane, none);
    for (const Four* const lanes :
         {&contact.rest, &contact.bias, &contact.effective_mass, &contact.gap, &contact.slop, &contact.share,
          &contact.bounce, &contact.impulse, &contact.total, &contact.start, &rows.speed, &rows.frictions.mass_11,
          &rows.frictions.mass_12, &rows.frictions.mass_22, &rows.frictions.sliding_mass})
        CHECK((*lanes)[lane] == 0.0f);
    for (size_t k = 0; k < 2; ++k) check_friction(rows.frictions, lane, k, {}, 0.0f);
}

const GroundStep step{.min_bounce_speed = 0.2f};

// A body and its contact points. Some bodies do not slide; some spin about a vertical axis through one of their points.
struct Grounded {
    SolverBody body;
    GroundManifold ground;

    explicit Grounded(uint64_t seed) {
        test::Random random(seed);
        const auto number = [&](double size) { return static_cast<float>(random.uniform(-size, size)); };
        const auto random_vector = [&](double size) {
            return glm::vec3(random.point(glm::dvec3(-size), glm::dvec3(size)));
        };
        body = {.inverse_inertia = {{300.0f, 10.0f, 20.0f}, {10.0f, 200.0f, -30.0f}, {20.0f, -30.0f, 400.0f}},
                .centre = random_vector(5.0),
                .linear = random_vector(seed % 3 == 0 ? 0.1 : 6.0),
                .angular = random_vector(20.0),
                .inverse_mass = 0.7f + number(0.2),
                .share = static_cast<float>(random.uniform(0.1, 1.0))};
        // Upright: if it spins at all, then about a vertical axis through its second point, which does not slide.
        const bool upright = seed % 5 == 0;
        if (upright) body.linear = {0.0f, -0.08f, 0.0f};
        if (upright) body.angular = {0.0f, seed % 2 == 0 ? 3.0f : 0.0f, 0.0f};
        ground.count = 1 + static_cast<uint32_t>(seed % GroundManifold::max_points);
        ground.slop = 0.0001f * static_cast<float>(seed % 4);
        ground.restitution = seed % 2 == 0 ? 0.4f : 0.0f;
        for (uint32_t i = 0; i < ground.count; ++i) {
            GroundPoint& point = ground.all[i];
            point.position = body.centre + random_vector(0.1);
            point.distance = number(0.01);
            if (i % 3 != 2) point.start = {0.5f + number(0.5), random_vector(0.3)};
        }
        if (upright && ground.count > 1) ground.all[1].position = body.centre - glm::vec3(0.0f, 0.05f, 0.0f);
    }
};

} // namespace

TEST_CASE("ground rows: four points of one body equal one point at a time, bit for bit") {
    for (uint64_t seed = 0; seed < 200; ++seed) {
        INFO("seed ", seed);
        const Grounded one(seed);
        for (size_t first = 0; first < one.ground.count; first += 4) {
            const GroundRows rows = ground_rows(one.body, one.ground, first, step);
            for (size_t i = first; i < std::min<size_t>(one.ground.count, first + 4); ++i)
                check_point(rows, i - first, one.body, one.ground, i, step);
        }
    }
}

TEST_CASE("ground rows: four bodies equal one point at a time, bit for bit, and a missing point has a row of zeros") {
    for (uint64_t seed = 0; seed < 200; ++seed) {
        INFO("seed ", seed);
        const std::array<Grounded, 4> bodies{Grounded(seed), Grounded(3 * seed + 1), Grounded(seed + 7),
                                             Grounded(5 * seed + 2)};
        const auto each = [&](const auto& of) {
            return std::array{of(bodies[0]), of(bodies[1]), of(bodies[2]), of(bodies[3])};
        };
        const FourGrounded four(each([](const Grounded& one) { return &one.body; }),
                                each([](const Grounded& one) { return &one.ground; }));
        for (size_t index = 0; index < GroundManifold::max_points; ++index) {
            const GroundRows rows = ground_rows(four, index, step);
            for (size_t lane = 0; lane < 4; ++lane) {
                const Grounded& one = bodies[lane];
                if (index < one.ground.count) {
                    check_point(rows, lane, one.body, one.ground, index, step);
                    continue;
                }
                check_zero(rows, lane);
            }
        }
    }
}

TEST_CASE("ground rows: the tangents of the ground are unit vectors across each other and the normal") {
    const Tangents& tangents = tangents_of_ground();
    CHECK(std::abs(glm::length(tangents.first) - 1.0f) < 1e-6f);
    CHECK(std::abs(glm::length(tangents.second) - 1.0f) < 1e-6f);
    CHECK(glm::dot(tangents.first, tangents.second) == 0.0f);
    CHECK(tangents.first.y == 0.0f);
    CHECK(tangents.second.y == 0.0f);
}
