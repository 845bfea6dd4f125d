// Rows of contacts with static bodies: four bodies at a time equal one row after the other, bit for bit.
#include "physics/solver/static_rows.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include "tests/physics/convex_pieces.h"
#include "tests/physics/one_row.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

struct Contact {
    Row row, friction;
    float coefficient;
};

Row random_row(test::Random& random, uint32_t body, float inverse_mass) {
    const auto number = [&] { return static_cast<float>(random.uniform(-1.0, 1.0)); };
    Row row{};
    for (float* vector : {row.normal, row.angular_a, row.inverse_inertia_angular_a})
        for (int axis = 0; axis < 3; ++axis) vector[axis] = number();
    row.bias = number();
    row.effective_mass = 0.2f + 0.1f * number();
    row.impulse = 0.5f + 0.5f * number();
    row.a = body;
    row.inverse_mass_a = inverse_mass;
    return row;
}

// Every coupled_step-th body is in a bundle, because it also touches a body that moves; the others have all sweeps at
// once. 0: no body is in a bundle.
void check(uint64_t seed, uint32_t body_count, size_t contact_count, uint32_t coupled_step, uint32_t bundle_points) {
    INFO("seed ", seed, ", ", body_count, " bodies, ", contact_count, " contacts, coupled ", coupled_step,
         ", bundles of ", bundle_points);
    test::Random random(seed);
    std::vector<float> inverse_masses;
    for (uint32_t i = 0; i < body_count; ++i) // some have infinite mass
        inverse_masses.push_back(i % 7 == 3 ? 0.0f : static_cast<float>(random.uniform(0.1, 2.0)));
    std::vector<Contact> contacts;
    std::vector<uint32_t> bodies;
    for (size_t i = 0; i < contact_count; ++i) { // the first bodies have most of them
        const double u = random.uniform(0.0, 1.0);
        bodies.push_back(std::min(static_cast<uint32_t>(u * u * body_count), body_count - 1));
        contacts.push_back({random_row(random, bodies[i], inverse_masses[bodies[i]]),
                            random_row(random, bodies[i], inverse_masses[bodies[i]]),
                            static_cast<float>(random.uniform(0.0, 1.0))});
    }
    Bundles bundles; // pairs of coupled bodies that touch; the last one may be alone
    bundles.start(body_count);
    const auto coupled = [&](uint32_t body) { return coupled_step > 0 && body % coupled_step == 0; };
    for (uint32_t i = 0; coupled_step > 0 && i < body_count; i += 2 * coupled_step)
        bundles.join(i, i + coupled_step < body_count ? i + coupled_step : i, 1);
    bundles.finish(bundle_points);
    StaticRows rows;
    rows.arrange(bodies, inverse_masses, bundles);
    for (size_t i = contact_count; i-- > 0;)
        rows.put(i, contacts[i].row, contacts[i].friction, contacts[i].coefficient);

    std::vector<VelocityChange> expected(body_count), found(body_count);
    for (const Contact& contact : contacts) test::apply(contact.row, contact.row.impulse, expected[contact.row.a]);
    for (uint32_t bundle = bundles.count(); bundle-- > 0;) rows.apply(bundle, found.data());
    const int sweeps = 5;
    const uint32_t groups = rows.lone_groups();
    CHECK((groups > 0) == std::ranges::any_of(bodies, [&](uint32_t body) { return !coupled(body); }));
    rows.solve_lone(groups / 2, groups, sweeps, found.data());
    rows.solve_lone(0, groups / 2, sweeps, found.data());
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        for (Contact& contact : contacts)
            test::solve(contact.row, 0.0f, std::numeric_limits<float>::max(), expected[contact.row.a]);
        for (uint32_t bundle = 0; bundle < bundles.count(); ++bundle) rows.solve_contacts(bundle, found.data());
        for (Contact& contact : contacts) {
            const float bound = contact.coefficient * contact.row.impulse;
            test::solve(contact.friction, -bound, bound, expected[contact.row.a]);
        }
        for (uint32_t bundle = 0; bundle < bundles.count(); ++bundle) rows.solve_friction(bundle, found.data());
    }
    for (uint32_t i = 0; i < body_count; ++i)
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(found[i].linear[axis] == expected[i].linear[axis]);
            CHECK(found[i].angular[axis] == expected[i].angular[axis]);
        }
    for (size_t i = 0; i < contact_count; ++i) {
        CHECK(rows.impulses(i).contact == contacts[i].row.impulse);
        CHECK(rows.impulses(i).friction == contacts[i].friction.impulse);
        const Row back = rows.row(i);
        CHECK(std::memcmp(&back, &contacts[i].row, sizeof back) == 0);
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
            for (uint64_t seed = 10; seed < 30; ++seed) check(seed, 37, 150, coupled_step, bundle_points);
            check(30, 83, 600, coupled_step, bundle_points);
            check(31, 9, 1500, coupled_step, bundle_points); // many contacts a body
        }
}
