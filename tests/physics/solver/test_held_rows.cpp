// Rows of contacts with what never moves: four bodies at a time are what one at a time is, bit for bit.
#include "physics/solver/held_rows.h"

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

Row random_row(test::Random& random, uint32_t mover, float light) {
    const auto number = [&] { return static_cast<float>(random.uniform(-1.0, 1.0)); };
    Row row{};
    for (float* vector : {row.normal, row.arm_a, row.turn_a})
        for (int axis = 0; axis < 3; ++axis) vector[axis] = number();
    row.wanted = number();
    row.gain = 0.2f + 0.1f * number();
    row.impulse = 0.5f + 0.5f * number();
    row.a = mover;
    row.light_a = light;
    return row;
}

// Every so many movers have rows elsewhere, the others are solved at once; 0: none of them has.
void check(uint64_t seed, uint32_t mover_count, size_t contact_count, uint32_t coupled_step, uint32_t bundle_points) {
    INFO("seed ", seed, ", ", mover_count, " movers, ", contact_count, " contacts, rows elsewhere ", coupled_step,
         ", bundles of ", bundle_points);
    test::Random random(seed);
    std::vector<float> lights;
    for (uint32_t i = 0; i < mover_count; ++i) // some rest
        lights.push_back(i % 7 == 3 ? 0.0f : static_cast<float>(random.uniform(0.1, 2.0)));
    std::vector<Contact> contacts;
    std::vector<uint32_t> movers;
    for (size_t i = 0; i < contact_count; ++i) { // the first ones have most
        const double u = random.uniform(0.0, 1.0);
        movers.push_back(std::min(static_cast<uint32_t>(u * u * mover_count), mover_count - 1));
        contacts.push_back({random_row(random, movers[i], lights[movers[i]]),
                            random_row(random, movers[i], lights[movers[i]]),
                            static_cast<float>(random.uniform(0.0, 1.0))});
    }
    Bundles bundles; // of two bodies that touch, but for the last one
    bundles.start(mover_count);
    const auto coupled = [&](uint32_t mover) { return coupled_step > 0 && mover % coupled_step == 0; };
    for (uint32_t i = 0; coupled_step > 0 && i < mover_count; i += 2 * coupled_step)
        bundles.join(i, i + coupled_step < mover_count ? i + coupled_step : i, 1);
    bundles.finish(bundle_points);
    HeldRows rows;
    rows.arrange(movers, lights, bundles);
    for (size_t i = contact_count; i-- > 0;)
        rows.put(i, contacts[i].row, contacts[i].friction, contacts[i].coefficient);

    std::vector<Motion> expected(mover_count), found(mover_count);
    for (const Contact& contact : contacts) test::push(contact.row, contact.row.impulse, expected[contact.row.a]);
    for (uint32_t bundle = bundles.count(); bundle-- > 0;) rows.give(bundle, found.data());
    const int sweeps = 5;
    const uint32_t groups = rows.lone_groups();
    CHECK((groups > 0) == std::ranges::any_of(movers, [&](uint32_t mover) { return !coupled(mover); }));
    rows.settle(groups / 2, groups, sweeps, found.data());
    rows.settle(0, groups / 2, sweeps, found.data());
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        for (Contact& contact : contacts)
            test::solve(contact.row, 0.0f, std::numeric_limits<float>::max(), expected[contact.row.a]);
        for (uint32_t bundle = 0; bundle < bundles.count(); ++bundle) rows.press(bundle, found.data());
        for (Contact& contact : contacts) {
            const float most = contact.coefficient * contact.row.impulse;
            test::solve(contact.friction, -most, most, expected[contact.row.a]);
        }
        for (uint32_t bundle = 0; bundle < bundles.count(); ++bundle) rows.rub(bundle, found.data());
    }
    for (uint32_t i = 0; i < mover_count; ++i)
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

TEST_CASE("rows of four bodies at a time are solved as one after the other, bit for bit") {
    for (const uint32_t coupled_step : {1u, 0u, 2u, 5u})
        for (const uint32_t bundle_points : {1u, 6u, 1000u}) {
            check(1, 1, 0, coupled_step, bundle_points);
            check(2, 1, 1, coupled_step, bundle_points);
            check(3, 3, 9, coupled_step, bundle_points);  // fewer than four
            check(4, 5, 40, coupled_step, bundle_points); // one left over
            for (uint64_t seed = 10; seed < 30; ++seed) check(seed, 37, 150, coupled_step, bundle_points);
            check(30, 83, 600, coupled_step, bundle_points);
            check(31, 9, 1500, coupled_step, bundle_points); // very many of most
        }
}
