// Bodies that touch only the ground: sixteen at a time equal one row after the other, bit for bit.
#include "physics/solver/lone_bodies.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include "tests/physics/convex_pieces.h"
#include "tests/physics/one_row.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

const GroundStep step{
    .seconds = 1.0f / 120.0f, .gravity = {0.0f, -9.81f, 0.0f}, .min_bounce_speed = 0.2f, .warm_start_part = 0.85f};
constexpr int sweeps = 7;
constexpr float no_limit = std::numeric_limits<float>::max();

struct Bodies {
    std::vector<SolverBody> solver_bodies;
    std::vector<GroundManifold> grounds;

    // Points lie between `deep` below the ground and `high` above it, m.
    Bodies(uint64_t seed, size_t count, double deep, double high) : grounds(count) {
        test::Random random(seed);
        const auto number = [&](double size) { return static_cast<float>(random.uniform(-size, size)); };
        const auto vector = [&](double size) { return glm::vec3(random.point(glm::dvec3(-size), glm::dvec3(size))); };
        for (GroundManifold& ground : grounds) {
            solver_bodies.push_back(
                {.inverse_inertia = {{300.0f, 10.0f, 20.0f}, {10.0f, 200.0f, -30.0f}, {20.0f, -30.0f, 400.0f}},
                 .centre = vector(5.0),
                 .linear = vector(2.0),
                 .angular = vector(20.0),
                 .inverse_mass = 0.7f + number(0.3)});
            ground.count = 1 + static_cast<uint32_t>(random.uniform(0.0, 11.999));
            ground.restitution = number(0.5) + 0.5f;
            ground.friction = number(0.5) + 0.5f;
            for (GroundPoint& point : ground.points()) {
                point.position = solver_bodies.back().centre + vector(0.1);
                point.distance = static_cast<float>(random.uniform(-deep, high));
                point.normal_impulse = 0.5f + number(0.5);
                point.blow = number(1.0) > 0.5f;
            }
        }
    }
};

Row row_of(const FourRows& rows, size_t lane, float inverse_mass) {
    Row row{};
    for (size_t axis = 0; axis < 3; ++axis) {
        row.normal[axis] = rows.normal[axis][lane];
        row.angular_a[axis] = rows.angular[axis][lane];
        row.inverse_inertia_angular_a[axis] = rows.inverse_inertia_angular[axis][lane];
    }
    row.bias = rows.bias[lane];
    row.effective_mass = rows.effective_mass[lane];
    row.impulse = rows.impulse[lane];
    row.inverse_mass_a = inverse_mass;
    return row;
}

// Solves one body alone, one row after the other.
void solve_one(const SolverBody& body, GroundManifold& ground, VelocityChange& change, VelocityChange& correction) {
    std::array<Row, GroundManifold::max_points> contacts, frictions, overlaps;
    for (size_t i = 0; i < ground.count; ++i) {
        const GroundRows rows = ground_rows(body, ground, i / 4 * 4, step);
        contacts[i] = overlaps[i] = row_of(rows.contacts, i % 4, body.inverse_mass);
        frictions[i] = row_of(rows.frictions, i % 4, body.inverse_mass);
        overlaps[i].bias = rows.correction[i % 4];
        overlaps[i].impulse = 0.0f;
        ground.all[i].speed = rows.speed[i % 4];
        for (size_t axis = 0; axis < 3; ++axis)
            ground.all[i].tangent[static_cast<int>(axis)] = frictions[i].normal[axis];
    }
    for (size_t i = 0; i < ground.count; ++i) test::apply(contacts[i], contacts[i].impulse, change);
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        for (size_t i = 0; i < ground.count; ++i) test::solve(contacts[i], 0.0f, no_limit, change);
        for (size_t i = 0; i < ground.count; ++i) {
            const float bound = ground.friction * contacts[i].impulse;
            test::solve(frictions[i], -bound, bound, change);
        }
        for (size_t i = 0; i < ground.count; ++i)
            if (overlaps[i].bias != 0.0f) test::solve(overlaps[i], 0.0f, no_limit, correction);
    }
    for (size_t i = 0; i < ground.count; ++i) {
        GroundPoint& point = ground.all[i];
        point.normal_impulse = contacts[i].impulse;
        point.friction_impulse = frictions[i].impulse;
        point.blow = point.speed > blow_speed;
    }
}

void check(const VelocityChange& found, const VelocityChange& expected) {
    for (int axis = 0; axis < 3; ++axis) {
        CHECK(found.linear[axis] == expected.linear[axis]);
        CHECK(found.angular[axis] == expected.angular[axis]);
    }
}

// Every third body is not added, because it touches something else: nothing of it may change.
void check(uint64_t seed, size_t count, double deep, double high) {
    INFO("seed ", seed, ", ", count, " bodies, ", deep, " deep, ", high, " high");
    Bodies found(seed, count, deep, high);
    Bodies expected = found;
    std::vector<VelocityChange> changes(count), corrections(count);
    LoneBodies lone;
    for (int again = 0; again < 2; ++again) { // clear() forgets the bodies added before
        lone.clear();
        for (size_t i = 0; i < count; ++i)
            if (i % 3 != 2) lone.add(found.grounds[i], static_cast<uint32_t>(i));
    }
    lone.arrange();
    const uint32_t groups = lone.groups();
    CHECK((groups > 0) == (count > 0));
    const LoneBodies::State state{found.solver_bodies.data(), changes.data(), corrections.data()};
    lone.solve(groups / 2, groups, state, step, sweeps);
    lone.solve(0, groups / 2, state, step, sweeps);
    bool some_corrected = false, some_blow = false;
    for (size_t i = 0; i < count; ++i) {
        INFO("body ", i);
        VelocityChange change{}, correction{};
        if (i % 3 != 2) solve_one(expected.solver_bodies[i], expected.grounds[i], change, correction);
        check(changes[i], change);
        check(corrections[i], correction);
        some_corrected = some_corrected || correction.linear[1] != 0.0f;
        for (size_t k = 0; k < found.grounds[i].count; ++k) {
            const GroundPoint &point = found.grounds[i].all[k], &right = expected.grounds[i].all[k];
            CHECK(point.speed == right.speed);
            CHECK(point.normal_impulse == right.normal_impulse);
            CHECK(point.friction_impulse == right.friction_impulse);
            CHECK(point.tangent == right.tangent);
            CHECK(point.blow == right.blow);
            some_blow = some_blow || point.blow;
        }
    }
    CHECK(some_corrected == (deep > 0.0 && count > 0));
    CHECK(some_blow == (count > 0));
}

} // namespace

TEST_CASE("lone bodies: sixteen side by side equal each body solved alone, bit for bit") {
    check(1, 0, 0.01, 0.01);
    check(6, 1, 0.01, 0.0);                                                    // one in a block
    check(3, 7, 0.01, 0.01);                                                   // a block and one left over
    check(4, 24, 0.0, 0.01);                                                   // no overlap
    check(5, 25, 0.01, 0.0);                                                   // all overlap
    for (uint64_t seed = 10; seed < 30; ++seed) check(seed, 150, 0.002, 0.01); // some overlap
}
