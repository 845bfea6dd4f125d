// Rows of contacts with static bodies: four bodies at a time equal one row after the other, bit for bit.
#include "physics/solver/static_rows.h"

#include <algorithm>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "physics/solver/transform.h"
#include "tests/physics/convex_pieces.h"
#include "tests/physics/one_row.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

const Substeps steps{.count = 4,
                     .first = 2,
                     .second = 2,
                     .last = 1,
                     .bounce = 3,
                     .seconds = 1.0f / 240.0f,
                     .gravity = {0.3f, -9.81f, 0.1f},
                     .push_part = 0.125f,
                     .static_push_part = 0.125f};

struct RandomNumbers : test::Random {
    using Random::Random;
    float number(double size) { return static_cast<float>(uniform(-size, size)); }
    float between(double low, double high) { return static_cast<float>(uniform(low, high)); }
    glm::vec3 vector(double size) { return glm::vec3(point(glm::dvec3(-size), glm::dvec3(size))); }
};

void put(float* to, const glm::vec3& from) {
    for (int axis = 0; axis < 3; ++axis) to[axis] = from[axis];
}

SolverBody random_body(RandomNumbers& random, bool infinite_mass) {
    if (infinite_mass) return {};
    const float turning = random.between(0.5, 50.0);
    return {.inverse_inertia = {{turning, 0, 0}, {0, turning, 0}, {0, 0, turning}},
            .linear = random.vector(2.0),
            .angular = random.vector(10.0),
            .inverse_mass = random.between(0.1, 2.0),
            .inertia = {{1.0f / turning, 0, 0}, {0, 1.0f / turning, 0}, {0, 0, 1.0f / turning}},
            .mass = random.between(0.5, 10.0)};
}

// J of a direction at an arm, and -J v; returns J M^-1 J^T.
float along(const glm::vec3& direction, const glm::vec3& arm, const SolverBody& body, float* of_direction,
            float* angular, float* turn, float& rest) {
    const glm::vec3 around = glm::cross(arm, direction), turning = around * body.inverse_inertia[0].x;
    put(of_direction, direction);
    put(angular, around);
    put(turn, turning);
    rest = -(glm::dot(direction, body.linear) + glm::dot(around, body.angular));
    return body.inverse_mass + glm::dot(around, turning);
}

test::Touch random_touch(RandomNumbers& random, uint32_t index, const SolverBody& body) {
    const glm::vec3 normal = random.direction(), arm = random.vector(0.3);
    const Tangents tangents = tangents_of(normal);
    test::Touch touch;
    Row& row = touch.row;
    const float response = along(normal, arm, body, row.normal, row.angular_a, row.inverse_inertia_angular_a, row.rest);
    row.effective_mass = response > 0.0f ? 1.0f / response : 0.0f;
    row.rest *= row.effective_mass;
    row.gap = random.number(0.004);
    row.slop = 0.001f;
    row.share = random.between(0.1, 1.0);
    row.bounce = std::max(0.0f, random.number(1.0)) * row.effective_mass;
    row.impulse = row.start = std::max(0.0f, random.number(0.02));
    row.a = index;
    row.inverse_mass_a = body.inverse_mass;
    FrictionRows& rows = touch.friction;
    float responses[2];
    for (int k = 0; k < 2; ++k) {
        FrictionRows::Along& to = rows.along[k];
        responses[k] = along(k == 0 ? tangents.first : tangents.second, arm, body, to.tangent, to.angular_a,
                             to.inverse_inertia_angular_a, to.rest);
        rows.impulse[k] = random.number(0.01);
    }
    float between = 0.0f;
    for (int axis = 0; axis < 3; ++axis)
        between += rows.along[0].inverse_inertia_angular_a[axis] * rows.along[1].angular_a[axis];
    const float determinant = responses[0] * responses[1] - between * between;
    if (determinant > 0.0f) {
        rows.mass_11 = responses[1] / determinant;
        rows.mass_12 = -between / determinant;
        rows.mass_22 = responses[0] / determinant;
        rows.sliding_mass = 1.0f / (responses[0] + responses[1]);
    }
    rows.a = index;
    rows.inverse_mass_a = body.inverse_mass;
    touch.coefficient = random.between(0.0, 1.0);
    return touch;
}

void write(const glm::vec3& v, std::array<Four, 3>& to, size_t lane) {
    for (size_t axis = 0; axis < 3; ++axis) to[axis][lane] = v[static_cast<int>(axis)];
}
glm::vec3 vector(const float* v) {
    return {v[0], v[1], v[2]};
}

// Puts a contact in through one lane of four rows.
void put_lane(StaticRows& rows, size_t contact, const test::Touch& touch, size_t lane) {
    FourRows four{};
    FourFrictions frictions{};
    const Row& row = touch.row;
    write(vector(row.normal), four.normal, lane);
    write(vector(row.angular_a), four.angular, lane);
    write(vector(row.inverse_inertia_angular_a), four.inverse_inertia_angular, lane);
    four.rest[lane] = row.rest;
    four.effective_mass[lane] = row.effective_mass;
    four.gap[lane] = row.gap;
    four.slop[lane] = row.slop;
    four.share[lane] = row.share;
    four.bounce[lane] = row.bounce;
    four.impulse[lane] = row.impulse;
    four.start[lane] = row.start;
    for (size_t k = 0; k < 2; ++k) {
        const FrictionRows::Along& from = touch.friction.along[k];
        FourFrictions::Along& to = frictions.along[k];
        write(vector(from.tangent), to.tangent, lane);
        write(vector(from.angular_a), to.angular, lane);
        write(vector(from.inverse_inertia_angular_a), to.inverse_inertia_angular, lane);
        to.rest[lane] = from.rest;
        to.impulse[lane] = touch.friction.impulse[k];
    }
    frictions.mass_11[lane] = touch.friction.mass_11;
    frictions.mass_12[lane] = touch.friction.mass_12;
    frictions.mass_22[lane] = touch.friction.mass_22;
    frictions.sliding_mass[lane] = touch.friction.sliding_mass;
    rows.put(contact, four, frictions, lane, touch.coefficient);
}

void check_equal(const VelocityChange& found, const VelocityChange& expected) {
    for (int axis = 0; axis < 3; ++axis) {
        CHECK(found.linear[axis] == expected.linear[axis]);
        CHECK(found.angular[axis] == expected.angular[axis]);
    }
}

struct Scene {
    std::vector<test::Touching> bodies;
    std::vector<uint32_t> body_of; // by contact
    std::vector<size_t> place_of;  // by contact: among those of its body

    // Some bodies have infinite mass; the first bodies have most contacts.
    Scene(uint64_t seed, uint32_t body_count, size_t contact_count) {
        RandomNumbers random(seed);
        for (uint32_t i = 0; i < body_count; ++i) bodies.push_back({random_body(random, i % 7 == 3), {}});
        for (size_t i = 0; i < contact_count; ++i) {
            const double u = random.uniform(0.0, 1.0);
            const uint32_t body = std::min(static_cast<uint32_t>(u * u * body_count), body_count - 1);
            test::Touching& one = bodies[body];
            body_of.push_back(body);
            place_of.push_back(one.touches.size());
            one.touches.push_back(random_touch(random, body, one.body));
        }
    }
    [[nodiscard]] const test::Touch& touch(size_t contact) const {
        return bodies[body_of[contact]].touches[place_of[contact]];
    }
    [[nodiscard]] std::vector<float> inverse_masses() const {
        std::vector<float> masses;
        for (const test::Touching& one : bodies) masses.push_back(one.body.inverse_mass);
        return masses;
    }
};

// All substeps of the bodies in a bundle, part by part. After each part, all velocities equal those of the oracle.
void check_bundles(StaticRows& rows, const Bundles& bundles, std::vector<test::Touching*> coupled,
                   std::vector<VelocityChange>& changes, std::vector<Displacement>& moved, std::vector<uint8_t>& acted,
                   const std::vector<uint32_t>& indices) {
    const auto check = [&] {
        for (size_t i = 0; i < coupled.size(); ++i) {
            check_equal(changes[indices[i]], coupled[i]->change);
            check_equal(moved[indices[i]], coupled[i]->moved);
        }
    };
    const auto each = [&](const auto& part, const auto& oracle) {
        for (uint32_t bundle = bundles.count(); bundle-- > 0;) part(bundle);
        for (test::Touching* const one : coupled) oracle(*one);
        check();
    };
    const auto sweep = [&](int times) {
        for (int i = 0; i < times; ++i) {
            each([&](uint32_t bundle) { rows.solve_contacts(bundle, changes.data()); }, test::solve_contacts);
            each([&](uint32_t bundle) { rows.solve_friction(bundle, changes.data()); }, test::solve_friction);
        }
    };
    for (int substep = 0; substep < steps.count; ++substep) {
        for (size_t i = 0; i < coupled.size(); ++i) {
            test::fall(*coupled[i], steps);
            changes[indices[i]] = coupled[i]->change;
        }
        each([&](uint32_t bundle) { rows.start(bundle, steps, moved.data()); },
             [](test::Touching& one) { test::start(one, steps); });
        each([&](uint32_t bundle) { rows.apply(bundle, changes.data()); }, test::warm);
        sweep(steps.first);
        for (size_t i = 0; i < coupled.size(); ++i) {
            test::move(*coupled[i], steps.seconds);
            moved[indices[i]] = coupled[i]->moved;
        }
        each([&](uint32_t bundle) { rows.start_second(bundle); }, test::start_second);
        const bool last = substep + 1 == steps.count;
        sweep(last ? steps.last : steps.second);
        if (last) {
            bool found = false, expected = false;
            each([&](uint32_t bundle) { found = rows.start_bounce(bundle) || found; },
                 [&](test::Touching& one) { expected = test::start_bounce(one) || expected; });
            CHECK(found == expected);
            sweep(steps.bounce);
        }
        each([&](uint32_t bundle) { rows.finish(bundle, acted.data()); }, test::finish);
    }
}

// Every coupled_step-th body is in a bundle, because it also touches a body that moves; the others have all substeps
// at once. 0: no body is in a bundle.
void check(uint64_t seed, uint32_t body_count, size_t contact_count, uint32_t coupled_step, uint32_t bundle_points) {
    INFO("seed ", seed, ", ", body_count, " bodies, ", contact_count, " contacts, coupled ", coupled_step,
         ", bundles of ", bundle_points);
    Scene scene(seed, body_count, contact_count);
    Bundles bundles; // pairs of coupled bodies that touch; the last one may be alone
    bundles.start(body_count);
    const auto is_coupled = [&](uint32_t body) { return coupled_step > 0 && body % coupled_step == 0; };
    for (uint32_t i = 0; coupled_step > 0 && i < body_count; i += 2 * coupled_step)
        bundles.join(i, i + coupled_step < body_count ? i + coupled_step : i, 1);
    bundles.finish(bundle_points);
    StaticRows rows;
    rows.arrange(scene.body_of, scene.inverse_masses(), bundles);
    for (size_t i = contact_count; i-- > 0;) {
        const test::Touch& touch = scene.touch(i);
        if (i % 3 == 0)
            put_lane(rows, i, touch, i % 4);
        else
            rows.put(i, touch.row, touch.friction, touch.coefficient);
    }

    std::vector<VelocityChange> changes(body_count);
    std::vector<Displacement> moved(body_count);
    std::vector<uint8_t> acted(body_count);
    std::vector<test::Touching*> coupled, lone;
    std::vector<SolverBody> solver_bodies;
    std::vector<uint32_t> indices;
    for (uint32_t i = 0; i < body_count; ++i) {
        test::Touching& one = scene.bodies[i];
        solver_bodies.push_back(one.body);
        if (is_coupled(i)) {
            coupled.push_back(&one);
            indices.push_back(i);
        } else if (!one.touches.empty()) {
            lone.push_back(&one);
        }
    }
    const uint32_t groups = rows.lone_groups();
    CHECK((groups > 0) == !lone.empty());
    const StaticRows::State state{solver_bodies.data(), changes.data(), moved.data(), acted.data()};
    rows.solve_lone(groups / 2, groups, steps, state);
    rows.solve_lone(0, groups / 2, steps, state);
    test::solve_by_sixteen(lone, steps);
    check_bundles(rows, bundles, coupled, changes, moved, acted, indices);
    for (uint32_t i = 0; i < body_count; ++i) {
        check_equal(changes[i], scene.bodies[i].change);
        check_equal(moved[i], scene.bodies[i].moved);
        CHECK((acted[i] != 0) == test::acted(scene.bodies[i]));
    }
    for (size_t i = 0; i < contact_count; ++i) {
        const StaticRows::Impulses found = rows.impulses(i);
        const test::Touch& expected = scene.touch(i);
        CHECK(found.total == expected.row.total);
        CHECK(found.start == expected.row.impulse);
        for (size_t k = 0; k < 2; ++k) {
            CHECK(found.friction_total[k] == expected.friction.total[k]);
            CHECK(found.friction_start[k] == expected.friction.impulse[k]);
        }
    }
}

} // namespace

TEST_CASE("static rows: four bodies side by side equal one row after the other, bit for bit") {
    for (const uint32_t coupled_step : {1u, 0u, 2u, 5u})
        for (const uint32_t bundle_points : {1u, 6u, 1000u}) {
            check(1, 1, 0, coupled_step, bundle_points);
            check(2, 1, 1, coupled_step, bundle_points);
            check(3, 3, 9, coupled_step, bundle_points);  // fewer than four
            check(4, 5, 40, coupled_step, bundle_points); // one left over
            for (uint64_t seed = 10; seed < 16; ++seed) check(seed, 37, 150, coupled_step, bundle_points);
            check(30, 83, 400, coupled_step, bundle_points);
            check(31, 9, 600, coupled_step, bundle_points); // many contacts a body
        }
}

TEST_CASE("static rows: the random contacts press, slide, stick, bounce, part and start from less than a blow") {
    size_t loaded = 0, parted = 0, slid = 0, stuck = 0, limited = 0, bounced = 0, still = 0;
    int blows = 0, energies = 0;
    for (uint64_t seed = 10; seed < 16; ++seed) {
        Scene scene(seed, 37, 150);
        std::vector<test::Touching*> all;
        for (test::Touching& one : scene.bodies) all.push_back(&one);
        bounced += test::solve_by_sixteen(all, steps) ? 1 : 0;
        for (const test::Touching* const one : all) {
            still += !one->touches.empty() && !test::acted(*one) ? 1 : 0;
            blows += one->blows;
            energies += one->limits;
            for (const auto& [row, friction, coefficient, was_limited] : one->touches) {
                if (row.effective_mass == 0.0f) continue;
                ++(row.impulse > 0.0f ? loaded : parted);
                const float bound = coefficient * row.impulse;
                const float length = std::hypot(friction.impulse[0], friction.impulse[1]);
                CHECK(length <= bound * 1.00001f);
                if (row.impulse > 0.0f) ++(length < 0.999f * bound ? stuck : slid);
                limited += was_limited ? 1 : 0;
            }
        }
    }
    for (const size_t enough : {loaded, parted, slid, stuck}) CHECK(enough > 30);
    CHECK(limited > 30);
    CHECK(blows > 30);
    CHECK(energies > 3);
    CHECK(still > 3); // no contact acts
    CHECK(bounced > 3);
}
