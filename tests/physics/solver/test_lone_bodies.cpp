// Bodies that touch only the ground: sixteen at a time are what one row after the other is, bit for bit.
#include "physics/solver/lone_bodies.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include "physics/solver/convert.h"
#include "tests/physics/convex_pieces.h"
#include "tests/physics/one_row.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

const GroundStep step{
    .seconds = 1.0f / 120.0f, .gravity = {0.0f, -98.1f, 0.0f}, .min_bounce_speed = 2.0f, .kept_impulse = 0.85f};
constexpr int sweeps = 7;
constexpr float no_limit = std::numeric_limits<float>::max();

struct Bodies {
    std::vector<Mover> movers;
    std::vector<GroundManifold> grounds;

    // Every third of those movers touches something else, and is not to be solved. How deep points are, and how high, at most.
    Bodies(uint64_t seed, size_t count, double deep, double high) : grounds(count) {
        test::Random random(seed);
        const auto number = [&](double size) { return static_cast<float>(random.uniform(-size, size)); };
        const auto vector = [&](double size) { return btVector3(number(size), number(size), number(size)); };
        for (GroundManifold& ground : grounds) {
            movers.push_back({.turning = {{3.0f, 0.1f, 0.2f}, {0.1f, 2.0f, -0.3f}, {0.2f, -0.3f, 4.0f}},
                              .centre = vector(50.0),
                              .linear = vector(20.0),
                              .angular = vector(20.0),
                              .light = 0.7f + number(0.3)});
            ground.count = 1 + static_cast<uint32_t>(random.uniform(0.0, 11.999));
            ground.restitution = number(0.5) + 0.5f;
            ground.friction = number(0.5) + 0.5f;
            for (GroundPoint& point : ground.points()) {
                point.position = packed(movers.back().centre + vector(1.0));
                point.distance = static_cast<float>(random.uniform(-deep, high));
                point.impulse = 5.0f + number(5.0);
                point.blow = number(1.0) > 0.5f;
            }
        }
    }
};

Row row_of(const FourRows& rows, size_t lane, float light) {
    Row row{};
    for (size_t axis = 0; axis < 3; ++axis) {
        row.normal[axis] = rows.normal[axis][lane];
        row.arm_a[axis] = rows.arm[axis][lane];
        row.turn_a[axis] = rows.turn[axis][lane];
    }
    row.wanted = rows.wanted[lane];
    row.gain = rows.gain[lane];
    row.impulse = rows.impulse[lane];
    row.light_a = light;
    return row;
}

// By itself, one row after the other.
void solve_one(const Mover& mover, GroundManifold& ground, Motion& motion, Motion& parting) {
    std::array<Row, GroundManifold::max_points> contacts, frictions, depths;
    for (size_t i = 0; i < ground.count; ++i) {
        const GroundRows rows = ground_rows(mover, ground, i / 4 * 4, step);
        contacts[i] = depths[i] = row_of(rows.contacts, i % 4, mover.light);
        frictions[i] = row_of(rows.frictions, i % 4, mover.light);
        depths[i].wanted = rows.depth[i % 4];
        depths[i].impulse = 0.0f;
        ground.all[i].speed = rows.speed[i % 4];
        for (size_t axis = 0; axis < 3; ++axis) ground.all[i].along[axis] = frictions[i].normal[axis];
    }
    for (size_t i = 0; i < ground.count; ++i) test::push(contacts[i], contacts[i].impulse, motion);
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        for (size_t i = 0; i < ground.count; ++i) test::solve(contacts[i], 0.0f, no_limit, motion);
        for (size_t i = 0; i < ground.count; ++i) {
            const float most = ground.friction * contacts[i].impulse;
            test::solve(frictions[i], -most, most, motion);
        }
        for (size_t i = 0; i < ground.count; ++i)
            if (depths[i].wanted != 0.0f) test::solve(depths[i], 0.0f, no_limit, parting);
    }
    for (size_t i = 0; i < ground.count; ++i) {
        GroundPoint& point = ground.all[i];
        point.impulse = contacts[i].impulse;
        point.friction = frictions[i].impulse;
        point.blow = point.speed > 0.2f * bullet_units;
    }
}

void check(const Motion& found, const Motion& expected) {
    for (int axis = 0; axis < 3; ++axis) {
        CHECK(found.linear[axis] == expected.linear[axis]);
        CHECK(found.angular[axis] == expected.angular[axis]);
    }
}

void check(uint64_t seed, size_t count, double deep, double high) {
    INFO("seed ", seed, ", ", count, " bodies, ", deep, " deep, ", high, " high");
    Bodies found(seed, count, deep, high);
    Bodies expected = found;
    std::vector<Motion> motions(count), parting(count);
    LoneBodies lone;
    for (int again = 0; again < 2; ++again) { // what was there before is forgotten
        lone.clear();
        for (size_t i = 0; i < count; ++i)
            if (i % 3 != 2) lone.add(found.grounds[i], static_cast<uint32_t>(i));
    }
    lone.arrange();
    const uint32_t groups = lone.groups();
    CHECK((groups > 0) == (count > 0));
    const LoneBodies::Movers movers{found.movers.data(), motions.data(), parting.data()};
    lone.solve(groups / 2, groups, movers, step, sweeps);
    lone.solve(0, groups / 2, movers, step, sweeps);
    bool some_part = false, some_blow = false;
    for (size_t i = 0; i < count; ++i) {
        INFO("body ", i);
        Motion motion{}, parted{};
        if (i % 3 != 2) solve_one(expected.movers[i], expected.grounds[i], motion, parted);
        check(motions[i], motion);
        check(parting[i], parted);
        some_part = some_part || parted.linear[1] != 0.0f;
        for (size_t k = 0; k < found.grounds[i].count; ++k) {
            const GroundPoint &point = found.grounds[i].all[k], &wanted = expected.grounds[i].all[k];
            CHECK(point.speed == wanted.speed);
            CHECK(point.impulse == wanted.impulse);
            CHECK(point.friction == wanted.friction);
            CHECK(point.along == wanted.along);
            CHECK(point.blow == wanted.blow);
            some_blow = some_blow || point.blow;
        }
    }
    CHECK(some_part == (deep > 0.0 && count > 0));
    CHECK(some_blow == (count > 0));
}

} // namespace

TEST_CASE("bodies that touch only the ground are solved side by side as each by itself, bit for bit") {
    check(1, 0, 0.1, 0.1);
    check(2, 1, 0.1, 0.0);                                                   // one in a block
    check(3, 7, 0.1, 0.1);                                                   // a block and one left over
    check(4, 24, 0.0, 0.1);                                                  // nothing to part
    check(5, 25, 0.1, 0.0);                                                  // all
    for (uint64_t seed = 10; seed < 30; ++seed) check(seed, 150, 0.02, 0.1); // some
}
