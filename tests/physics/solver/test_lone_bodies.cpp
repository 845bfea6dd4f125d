// Bodies that touch only the ground: sixteen at a time equal one row after the other, bit for bit.
#include "physics/solver/lone_bodies.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include "tests/physics/convex_pieces.h"
#include "tests/physics/one_row.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

const GroundStep step{.min_bounce_speed = 0.2f};

struct Bodies {
    std::vector<SolverBody> solver_bodies;
    std::vector<GroundManifold> grounds;

    // Points lie between `deep` below the ground and `high` above it, m. Half of the bodies hardly move.
    Bodies(uint64_t seed, size_t count, double deep, double high) : grounds(count) {
        test::Random random(seed);
        const auto number = [&](double size) { return static_cast<float>(random.uniform(-size, size)); };
        const auto vector = [&](double size) { return glm::vec3(random.point(glm::dvec3(-size), glm::dvec3(size))); };
        for (GroundManifold& ground : grounds) {
            const double speed = solver_bodies.size() % 2 == 0 ? 2.0 : 0.01;
            solver_bodies.push_back(
                {.inverse_inertia = {{300.0f, 10.0f, 20.0f}, {10.0f, 200.0f, -30.0f}, {20.0f, -30.0f, 400.0f}},
                 .centre = vector(5.0),
                 .linear = vector(speed),
                 .angular = vector(10.0 * speed),
                 .inverse_mass = 0.7f + number(0.3),
                 .inertia = {{0.0034f, -0.0002f, -0.0002f}, {-0.0002f, 0.0051f, 0.0004f}, {-0.0002f, 0.0004f, 0.0025f}},
                 .mass = 1.4f + number(0.4)});
            ground.count = 1 + static_cast<uint32_t>(random.uniform(0.0, 11.999));
            ground.restitution = number(0.5) + 0.5f;
            ground.friction = number(0.5) + 0.5f;
            ground.slop = 0.0005f + number(0.0005);
            for (GroundPoint& point : ground.points()) {
                point.position = solver_bodies.back().centre + vector(0.1);
                point.distance = static_cast<float>(random.uniform(-deep, high));
                if (number(1.0) > 0.5f) point.start = {0.05f + number(0.05), vector(0.03)};
            }
        }
    }
};

// One contact of a lane.
test::Touch touch_of(const GroundRows& rows, size_t lane, float inverse_mass, float coefficient) {
    test::Touch touch;
    const auto copy = [lane](const std::array<Four, 3>& from, float* to) {
        for (size_t axis = 0; axis < 3; ++axis) to[axis] = from[axis][lane];
    };
    Row& row = touch.row;
    copy(rows.contacts.normal, row.normal);
    copy(rows.contacts.angular, row.angular_a);
    copy(rows.contacts.inverse_inertia_angular, row.inverse_inertia_angular_a);
    row.rest = rows.contacts.rest[lane];
    row.effective_mass = rows.contacts.effective_mass[lane];
    row.gap = rows.contacts.gap[lane];
    row.slop = rows.contacts.slop[lane];
    row.share = rows.contacts.share[lane];
    row.bounce = rows.contacts.bounce[lane];
    row.impulse = rows.contacts.impulse[lane];
    row.start = rows.contacts.start[lane];
    row.inverse_mass_a = inverse_mass;
    FrictionRows& friction = touch.friction;
    for (size_t k = 0; k < 2; ++k) {
        const FourFrictions::Along& from = rows.frictions.along[k];
        copy(from.tangent, friction.along[k].tangent);
        copy(from.angular, friction.along[k].angular_a);
        copy(from.inverse_inertia_angular, friction.along[k].inverse_inertia_angular_a);
        friction.along[k].rest = from.rest[lane];
        friction.impulse[k] = from.impulse[lane];
    }
    friction.mass_11 = rows.frictions.mass_11[lane];
    friction.mass_12 = rows.frictions.mass_12[lane];
    friction.mass_22 = rows.frictions.mass_22[lane];
    friction.sliding_mass = rows.frictions.sliding_mass[lane];
    friction.inverse_mass_a = inverse_mass;
    touch.coefficient = coefficient;
    return touch;
}

// A body alone, its rows one after the other.
test::Touching alone(const SolverBody& body, GroundManifold& ground) {
    test::Touching one{body, {}};
    for (size_t i = 0; i < ground.count; ++i) {
        const GroundRows rows = ground_rows(body, ground, i / 4 * 4, step);
        one.touches.push_back(touch_of(rows, i % 4, body.inverse_mass, ground.friction));
        ground.all[i].speed = rows.speed[i % 4];
    }
    return one;
}

void store(const test::Touching& one, GroundManifold& ground) {
    const Tangents& tangents = tangents_of_ground();
    const auto along = [&](const float* friction) {
        return tangents.first * friction[0] + tangents.second * friction[1];
    };
    for (size_t i = 0; i < ground.count; ++i) {
        const auto& [row, friction, coefficient, limited] = one.touches[i];
        GroundPoint& point = ground.all[i];
        point.last = {row.total, along(friction.total)};
        point.start = {row.impulse, along(friction.impulse)};
    }
}

void check_equal(const VelocityChange& found, const VelocityChange& expected) {
    for (int axis = 0; axis < 3; ++axis) {
        CHECK(found.linear[axis] == expected.linear[axis]);
        CHECK(found.angular[axis] == expected.angular[axis]);
    }
}

void check_equal(const PointImpulse& found, const PointImpulse& expected) {
    CHECK(found.normal == expected.normal);
    CHECK(found.friction == expected.friction);
}

struct Seen {
    bool pushed = false, bounced = false;
    size_t limited = 0, kept = 0, still = 0; // contacts, contacts and bodies
    int blows = 0, energies = 0;             // substeps of bodies
};

// Every third body is not added, because it touches something else: nothing of it may change.
Seen check(uint64_t seed, size_t count, double deep, double high, const Substeps& substeps) {
    INFO("seed ", seed, ", ", count, " bodies, ", deep, " deep, ", high, " high, ", substeps.count, " substeps");
    Bodies found(seed, count, deep, high);
    Bodies expected = found;
    std::vector<VelocityChange> changes(count);
    std::vector<Displacement> moved(count);
    std::vector<uint8_t> acted(count);
    LoneBodies lone;
    for (int again = 0; again < 2; ++again) { // clear() forgets the bodies added before
        lone.clear();
        for (size_t i = 0; i < count; ++i)
            if (i % 3 != 2) lone.add(found.grounds[i], static_cast<uint32_t>(i));
    }
    lone.arrange();
    const uint32_t groups = lone.groups();
    CHECK((groups > 0) == (count > 0));
    const StaticRows::State state{found.solver_bodies.data(), changes.data(), moved.data(), acted.data()};
    lone.solve(groups / 2, groups, state, step, substeps);
    lone.solve(0, groups / 2, state, step, substeps);

    std::vector<test::Touching> all;
    std::vector<test::Touching*> solved;
    for (size_t i = 0; i < count; ++i) all.push_back(alone(expected.solver_bodies[i], expected.grounds[i]));
    for (size_t i = 0; i < count; ++i)
        if (i % 3 != 2) solved.push_back(&all[i]);
    Seen seen;
    seen.bounced = test::solve_by_sixteen(solved, substeps);
    for (size_t i = 0; i < count; ++i) {
        INFO("body ", i);
        if (i % 3 != 2)
            store(all[i], expected.grounds[i]);
        else
            for (GroundPoint& point : expected.grounds[i].points()) point.speed = 0.0f;
        check_equal(changes[i], all[i].change);
        check_equal(moved[i], all[i].moved);
        CHECK((acted[i] != 0) == (i % 3 != 2 && test::acted(all[i])));
        seen.still += i % 3 != 2 && acted[i] == 0 ? 1 : 0;
        seen.blows += all[i].blows;
        seen.energies += all[i].limits;
        for (size_t k = 0; k < found.grounds[i].count; ++k) {
            const GroundPoint &point = found.grounds[i].all[k], &right = expected.grounds[i].all[k];
            CHECK(point.speed == right.speed);
            check_equal(point.last, right.last);
            check_equal(point.start, right.start);
            if (i % 3 == 2 || !(point.last.normal > 0.0f)) continue;
            ++(all[i].touches[k].limited ? seen.limited : seen.kept);
            seen.pushed = seen.pushed || point.distance < -found.grounds[i].slop;
        }
    }
    return seen;
}

const Substeps steps{.count = 4,
                     .first = 2,
                     .second = 2,
                     .last = 1,
                     .bounce = 3,
                     .seconds = 1.0f / 480.0f,
                     .gravity = {0.0f, -9.81f, 0.0f},
                     .push_part = 0.0625f,
                     .static_push_part = 0.0625f};

} // namespace

TEST_CASE("lone bodies: sixteen side by side equal each body solved alone, bit for bit") {
    CHECK_FALSE(check(1, 0, 0.01, 0.01, steps).bounced);
    check(6, 1, 0.01, 0.0, steps);                      // one in a block
    check(3, 7, 0.01, 0.01, steps);                     // a block and one left over
    CHECK_FALSE(check(4, 24, 0.0, 0.01, steps).pushed); // no overlap
    CHECK(check(5, 25, 0.01, 0.0, steps).pushed);       // all overlap
    size_t still = 0;
    int energies = 0;
    for (uint64_t seed = 10; seed < 20; ++seed) { // some overlap
        const Seen seen = check(seed, 400, 0.002, 0.01, steps);
        CHECK(seen.pushed);
        CHECK(seen.bounced);
        CHECK(seen.limited > 10);
        CHECK(seen.kept > 10);
        CHECK(seen.blows > 3);
        energies += seen.energies;
        still += seen.still;
    }
    CHECK(still > 3);
    CHECK(energies > 3);
    check(30, 40, 0.002, 0.01,
          {.count = 1, .first = 5, .seconds = 1.0f / 120.0f, .push_part = 0.0625f, .static_push_part = 0.0625f});
    check(31, 40, 0.002, 0.01,
          {.count = 0, .first = 5, .seconds = 1.0f / 120.0f, .push_part = 0.0625f, .static_push_part = 0.0625f});
}

TEST_CASE("lone bodies: a body at rest on its corners takes its weight from the ground, and a fast one bounces") {
    const auto drop = [](float speed, float restitution, float gap) {
        const SolverBody body{.inverse_inertia = {{6, 0, 0}, {0, 6, 0}, {0, 0, 6}},
                              .centre = {0.0f, 0.5f, 0.0f},
                              .linear = {0.0f, -speed, 0.0f},
                              .inverse_mass = 1.0f};
        GroundManifold ground;
        ground.count = 4;
        ground.friction = 0.5f;
        ground.restitution = restitution;
        for (size_t i = 0; i < 4; ++i) {
            ground.all[i].position = {i & 1 ? 0.5f : -0.5f, 0.0f, i & 2 ? 0.5f : -0.5f};
            ground.all[i].distance = gap;
        }
        VelocityChange change{};
        Displacement moved{};
        uint8_t acted = 0;
        LoneBodies lone;
        lone.add(ground, 0);
        lone.arrange();
        Substeps many = steps;
        many.first = many.second = many.last = many.bounce = 30;
        lone.solve(0, lone.groups(), {&body, &change, &moved, &acted}, step, many);
        CHECK(acted == 1);
        float lift = 0.0f;
        for (const GroundPoint& point : ground.points()) {
            CHECK(point.speed == speed);
            lift += point.last.normal;
        }
        CHECK(std::abs(moved.linear[1] + gap) < 1e-6f); // it comes to the ground and stays there in the step
        const float after = body.linear.y + change.linear[1];
        // Momentum: the ground gives what gravity and the speeds before and after ask for.
        CHECK(lift == doctest::Approx(after + speed + 9.81f / 120.0f).epsilon(1e-3));
        return after;
    };
    CHECK(std::abs(drop(0.0f, 0.9f, 0.0f)) < 1e-5f);
    CHECK(std::abs(drop(0.19f, 0.9f, 0.0f)) < 1e-5f); // too slow to bounce
    CHECK(drop(2.0f, 0.0f, 0.0f) == doctest::Approx(0.0).epsilon(1e-5));
    CHECK(drop(2.0f, 0.5f, 0.0f) == doctest::Approx(1.0).epsilon(1e-3));
    for (const float gap : {0.001f, 0.01f, 0.04f}) // reached in one of the substeps: the bounce is whole
        CHECK(drop(6.0f, 0.5f, gap) == doctest::Approx(3.0).epsilon(1e-3));
}
