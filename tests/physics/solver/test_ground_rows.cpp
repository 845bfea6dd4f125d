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

struct OneRow {
    glm::vec3 normal{0.0f}, angular{0.0f}, inverse_inertia_angular{0.0f};
    float bias = 0.0f, effective_mass = 0.0f;
};

// The row along a normal at a point; its bias takes away the speed along the normal.
OneRow row_of(const glm::vec3& normal, const glm::vec3& at, const SolverBody& body) {
    OneRow row{.normal = normal, .angular = glm::cross(at - body.centre, normal)};
    row.inverse_inertia_angular = {glm::dot(body.inverse_inertia[0], row.angular),
                                   glm::dot(body.inverse_inertia[1], row.angular),
                                   glm::dot(body.inverse_inertia[2], row.angular)};
    row.effective_mass = 1.0f / (body.inverse_mass + glm::dot(row.inverse_inertia_angular, row.angular));
    row.bias = -(glm::dot(normal, body.linear) + glm::dot(row.angular, body.angular)) * row.effective_mass;
    return row;
}

void check_row(const FourRows& rows, size_t lane, const OneRow& row) {
    for (size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<int>(axis);
        CHECK(rows.normal[axis][lane] == row.normal[i]);
        CHECK(rows.angular[axis][lane] == row.angular[i]);
        CHECK(rows.inverse_inertia_angular[axis][lane] == row.inverse_inertia_angular[i]);
    }
    CHECK(rows.bias[lane] == row.bias);
    CHECK(rows.effective_mass[lane] == row.effective_mass);
}

void check_point(const GroundRows& rows, size_t lane, const SolverBody& body, const GroundManifold& ground,
                 size_t index, const GroundStep& step) {
    const GroundPoint& point = ground.all[index];
    const glm::vec3 at = point.position, up(0, 1, 0);
    OneRow contact = row_of(up, at, body);
    const float apart = -contact.bias / contact.effective_mass;
    const float before = apart - glm::dot(up, step.gravity) * step.seconds;
    float bounce = 0.0f;
    if (std::abs(before) >= step.min_bounce_speed && before < 0.0f) bounce = -before * ground.restitution;
    contact.bias += (bounce - std::max(point.distance, 0.0f) / step.seconds) * contact.effective_mass;
    check_row(rows.contacts, lane, contact);
    CHECK(rows.contacts.impulse[lane] == (point.blow ? 0.0f : point.normal_impulse * step.warm_start_part));
    CHECK(rows.speed[lane] == -before);
    if (point.distance >= 0.0f)
        CHECK(rows.correction[lane] == 0.0f);
    else
        CHECK(rows.correction[lane]
              == -point.distance * GroundRows::correction_part / step.seconds * contact.effective_mass);

    const glm::vec3 sliding = body.linear + glm::cross(body.angular, at - body.centre) - up * apart;
    glm::vec3 along = sliding;
    if (length_squared(sliding) > min_sliding_square)
        along *= 1.0f / std::sqrt(length_squared(sliding));
    else
        along = index % 2 == 0 ? glm::vec3(-1, 0, 0) : glm::vec3(0, 0, 1);
    check_row(rows.frictions, lane, row_of(along, at, body));
    CHECK(rows.frictions.impulse[lane] == 0.0f);
}

const GroundStep step{
    .seconds = 1.0f / 120.0f, .gravity = {0.0f, -9.81f, 0.0f}, .min_bounce_speed = 0.2f, .warm_start_part = 0.85f};

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
                .inverse_mass = 0.7f + number(0.2)};
        // Upright: if it spins at all, then about a vertical axis through its second point, which does not slide.
        const bool upright = seed % 5 == 0;
        if (upright) body.linear = {0.0f, -0.08f, 0.0f};
        if (upright) body.angular = {0.0f, seed % 2 == 0 ? 3.0f : 0.0f, 0.0f};
        ground.count = 1 + static_cast<uint32_t>(seed % GroundManifold::max_points);
        ground.restitution = seed % 2 == 0 ? 0.4f : 0.0f;
        for (uint32_t i = 0; i < ground.count; ++i)
            ground.all[i] = {.position = body.centre + random_vector(0.1),
                             .distance = number(0.01),
                             .normal_impulse = 0.5f + number(0.5),
                             .blow = i % 3 == 2};
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
                const OneRow none{};
                check_row(rows.contacts, lane, none);
                check_row(rows.frictions, lane, none);
                CHECK(rows.contacts.impulse[lane] == 0.0f);
                CHECK(rows.frictions.impulse[lane] == 0.0f);
                CHECK(rows.correction[lane] == 0.0f);
            }
        }
    }
}
