// Bundles of contacts without a common body, against a search for connected bodies by repeated passes.
#include "physics/solver/bundles.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

struct Touch {
    uint32_t a, b, points;
};

// By body: the lowest index among all bodies that it touches directly or through others.
std::vector<uint32_t> groups_of(uint32_t movers, const std::vector<Touch>& touches) {
    std::vector<uint32_t> lowest(movers);
    for (uint32_t i = 0; i < movers; ++i) lowest[i] = i;
    for (uint32_t round = 0; round < movers; ++round)
        for (const Touch& touch : touches)
            lowest[touch.a] = lowest[touch.b] = std::min(lowest[touch.a], lowest[touch.b]);
    return lowest;
}

void check(uint32_t movers, const std::vector<Touch>& touches, uint32_t least) {
    INFO(movers, " movers, ", touches.size(), " contacts, at least ", least);
    Bundles bundles;
    bundles.start(3); // start() forgets the contacts joined before
    bundles.join(0, 2, 7);
    bundles.finish(1);
    bundles.start(movers);
    for (const Touch& touch : touches) bundles.join(touch.a, touch.b, touch.points);
    bundles.finish(least);

    const std::vector<uint32_t> groups = groups_of(movers, touches);
    std::vector<uint32_t> points(bundles.count(), 0), of_group(movers, 0);
    std::set<uint32_t> touched;
    for (const Touch& touch : touches) {
        CHECK(bundles.of(touch.a) == bundles.of(touch.b));
        REQUIRE(bundles.of(touch.a) < bundles.count());
        points[bundles.of(touch.a)] += touch.points;
        of_group[groups[touch.a]] += touch.points;
        touched.insert({touch.a, touch.b});
    }
    for (uint32_t mover = 0; mover < movers; ++mover)
        if (!touched.contains(mover)) CHECK(bundles.of(mover) == Bundles::none);
    CHECK((bundles.count() == 0) == touches.empty());
    for (size_t i = 0; i + 1 < points.size(); ++i) CHECK(points[i] >= least);
    // A group of at least `least` points has a bundle of its own; the largest group is the first bundle.
    uint32_t largest = 0;
    for (uint32_t mover = 0; mover < movers; ++mover) {
        largest = std::max(largest, of_group[mover]);
        if (of_group[mover] >= least) CHECK(points[bundles.of(mover)] == of_group[mover]);
    }
    if (largest >= least && !points.empty()) CHECK(points[0] == largest);
}

} // namespace

TEST_CASE("bundles: no two have a body in common, and all but the last have the minimum of points") {
    check(0, {}, 4);
    check(5, {}, 4);
    check(2, {{1, 0, 3}}, 4);
    check(2, {{1, 0, 3}, {0, 1, 2}}, 1);
    check(6, {{0, 1, 1}, {2, 3, 1}, {4, 5, 1}}, 2);
    check(6, {{5, 3, 1}, {3, 1, 9}, {1, 5, 1}, {0, 2, 4}}, 4);
    for (uint64_t seed = 1; seed < 60; ++seed) {
        test::Random random(seed);
        const auto below = [&](uint32_t end) {
            return std::min(static_cast<uint32_t>(random.uniform(0.0, end)), end - 1);
        };
        const uint32_t movers = 2 + below(60);
        std::vector<Touch> touches;
        for (uint32_t i = below(80); i > 0; --i)
            if (const Touch touch{below(movers), below(movers), 1 + below(12)}; touch.a != touch.b)
                touches.push_back(touch);
        check(movers, touches, 1 + below(40));
    }
}
