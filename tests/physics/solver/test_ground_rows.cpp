// Rows of contacts with the ground: what four at a time give is what each by itself gives, bit for bit.
#include "physics/solver/ground_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <doctest/doctest.h>

#include "physics/solver/convert.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

struct OneRow {
    btVector3 normal{0, 0, 0}, arm{0, 0, 0}, turn{0, 0, 0};
    float wanted = 0.0f, gain = 0.0f;
};

// One row, as Catto has it: the impulse that takes the speed along the normal away.
OneRow row_of(const btVector3& normal, const btVector3& at, const Mover& mover) {
    OneRow row{.normal = normal, .arm = (at - mover.centre).cross(normal), .turn = {}, .wanted = 0.0f, .gain = 0.0f};
    row.turn = {mover.turning[0].dot(row.arm), mover.turning[1].dot(row.arm), mover.turning[2].dot(row.arm)};
    row.gain = 1.0f / (mover.light + row.turn.dot(row.arm));
    row.wanted = -(normal.dot(mover.linear) + row.arm.dot(mover.angular)) * row.gain;
    return row;
}

void check_row(const FourRows& rows, size_t lane, const OneRow& row) {
    for (size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<int>(axis);
        CHECK(rows.normal[axis][lane] == row.normal[i]);
        CHECK(rows.arm[axis][lane] == row.arm[i]);
        CHECK(rows.turn[axis][lane] == row.turn[i]);
    }
    CHECK(rows.wanted[lane] == row.wanted);
    CHECK(rows.gain[lane] == row.gain);
}

void check_point(const GroundRows& rows, size_t lane, const Mover& mover, const GroundManifold& ground, size_t index,
                 const GroundStep& step) {
    const GroundPoint& point = ground.all[index];
    const btVector3 at = unpacked(point.position), up(0, 1, 0);
    OneRow contact = row_of(up, at, mover);
    const float apart = -contact.wanted / contact.gain;
    const float before = apart - up.dot(step.gravity) * step.seconds;
    float bounce = 0.0f;
    if (std::abs(before) >= step.min_bounce_speed && before < 0.0f) bounce = -before * ground.restitution;
    contact.wanted += (bounce - std::max(point.distance, 0.0f) / step.seconds) * contact.gain;
    check_row(rows.contacts, lane, contact);
    CHECK(rows.contacts.impulse[lane] == (point.blow ? 0.0f : point.impulse * step.kept_impulse));
    CHECK(rows.speed[lane] == -before);
    if (point.distance >= 0.0f)
        CHECK(rows.depth[lane] == 0.0f);
    else
        CHECK(rows.depth[lane] == -point.distance * GroundRows::undone_part / step.seconds * contact.gain);

    const btVector3 sliding = mover.linear + mover.angular.cross(at - mover.centre) - up * apart;
    btVector3 along = sliding;
    if (sliding.length2() > SIMD_EPSILON)
        along /= std::sqrt(sliding.length2());
    else
        along = index % 2 == 0 ? btVector3(-1, 0, 0) : btVector3(0, 0, 1);
    check_row(rows.frictions, lane, row_of(along, at, mover));
    CHECK(rows.frictions.impulse[lane] == 0.0f);
}

const GroundStep step{
    .seconds = 1.0f / 120.0f, .gravity = {0.0f, -98.1f, 0.0f}, .min_bounce_speed = 2.0f, .kept_impulse = 0.85f};

// A body and what it touches the ground in; some do not slide, or turn about an axis through one of their points.
struct Grounded {
    Mover mover;
    GroundManifold ground;

    explicit Grounded(uint64_t seed) {
        test::Random random(seed);
        const auto number = [&](double size) { return static_cast<float>(random.uniform(-size, size)); };
        const auto random_vector = [&](double size) { return btVector3(number(size), number(size), number(size)); };
        mover = {.turning = {{3.0f, 0.1f, 0.2f}, {0.1f, 2.0f, -0.3f}, {0.2f, -0.3f, 4.0f}},
                 .centre = random_vector(50.0),
                 .linear = random_vector(seed % 3 == 0 ? 1.0 : 60.0),
                 .angular = random_vector(20.0),
                 .light = 0.7f + number(0.2)};
        const bool upright =
            seed % 5 == 0; // turns about an axis through its second point, if at all: that one does not slide
        if (upright) mover.linear = {0.0f, -0.8f, 0.0f};
        if (upright) mover.angular = {0.0f, seed % 2 == 0 ? 3.0f : 0.0f, 0.0f};
        ground.count = 1 + static_cast<uint32_t>(seed % GroundManifold::max_points);
        ground.restitution = seed % 2 == 0 ? 0.4f : 0.0f;
        for (uint32_t i = 0; i < ground.count; ++i)
            ground.all[i] = {.position = packed(mover.centre + random_vector(1.0)),
                             .distance = number(0.1),
                             .impulse = 5.0f + number(5.0),
                             .blow = i % 3 == 2};
        if (upright && ground.count > 1) ground.all[1].position = packed(mover.centre - btVector3(0.0f, 0.5f, 0.0f));
    }
};

} // namespace

TEST_CASE("rows of contacts with the ground are those of one point at a time, bit for bit") {
    for (uint64_t seed = 0; seed < 200; ++seed) {
        INFO("seed ", seed);
        const Grounded body(seed);
        for (size_t first = 0; first < body.ground.count; first += 4) {
            const GroundRows rows = ground_rows(body.mover, body.ground, first, step);
            for (size_t i = first; i < std::min<size_t>(body.ground.count, first + 4); ++i)
                check_point(rows, i - first, body.mover, body.ground, i, step);
        }
    }
}

TEST_CASE(
    "rows of four bodies on the ground are those of one point at a time, bit for bit, and who has fewer has none") {
    for (uint64_t seed = 0; seed < 200; ++seed) {
        INFO("seed ", seed);
        const std::array<Grounded, 4> bodies{Grounded(seed), Grounded(3 * seed + 1), Grounded(seed + 7),
                                             Grounded(5 * seed + 2)};
        const auto each = [&](const auto& of) {
            return std::array{of(bodies[0]), of(bodies[1]), of(bodies[2]), of(bodies[3])};
        };
        const FourGrounded four(each([](const Grounded& body) { return &body.mover; }),
                                each([](const Grounded& body) { return &body.ground; }));
        for (size_t index = 0; index < GroundManifold::max_points; ++index) {
            const GroundRows rows = ground_rows(four, index, step);
            for (size_t lane = 0; lane < 4; ++lane) {
                const Grounded& body = bodies[lane];
                if (index < body.ground.count) {
                    check_point(rows, lane, body.mover, body.ground, index, step);
                    continue;
                }
                const OneRow none{};
                check_row(rows.contacts, lane, none);
                check_row(rows.frictions, lane, none);
                CHECK(rows.contacts.impulse[lane] == 0.0f);
                CHECK(rows.frictions.impulse[lane] == 0.0f);
                CHECK(rows.depth[lane] == 0.0f);
            }
        }
    }
}
