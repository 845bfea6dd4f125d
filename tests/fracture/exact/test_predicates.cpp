// Compares the signs of the exact predicates with rational arithmetic.
#include "tests/fracture/predicates_oracle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "fracture/base/random.h"
#include "fracture/exact/predicates.h"

using namespace brittle::fracture;
using namespace brittle::fracture::exact;
using namespace brittle::fracture::exact::test;

TEST_CASE("snap moves only coordinates below the documented magnitude") {
    CHECK(snap(0.0) == 0.0);
    CHECK(snap(0.1) == 0.1);
    CHECK(snap(-0x1.fffffffffffffp-98) == -0x1.fffffffffffffp-98);
    CHECK(snap(0x1.0p-150) == 0x1.0p-150);
    CHECK(snap(-0x1.0p-150) == -0x1.0p-150);
    CHECK(snap(0x1.0p-152) == 0.0);
    CHECK(snap(5e-324) == 0.0);
    const double x = snap(1e-31);
    CHECK(std::abs(x - 1e-31) <= 0x1.0p-151);
    CHECK(std::fmod(x, coordinate_granularity) == 0.0);
}

TEST_CASE("of equal sites the lower index owns every point") {
    const std::vector<dvec3> sites{dvec3(0.25), dvec3(0.25), dvec3(0.25)};
    const Diagram diagram{sites, unit_box};
    PredicateStats stats;
    for (const dvec3& q : {dvec3(0.0), dvec3(0.25), dvec3(0.1, 0.2, 0.3)}) {
        CHECK(side1(diagram, 0, 1, q, stats) == 1);
        CHECK(side1(diagram, 1, 0, q, stats) == -1);
        CHECK(side1(diagram, 1, 2, q, stats) == 1);
    }
    CHECK(stats.perturbed == 9);
    CHECK(stats.exact_calls() == 9);
}

TEST_CASE("the predicates of a simple cell have the signs of a drawing") {
    // The cell of site 0 at the origin: x < 0.25, y < 0.25, z < 0.25.
    const std::vector<dvec3> sites{dvec3(0.0),       dvec3(0.5, 0, 0),     dvec3(0, 0.5, 0),
                                   dvec3(0, 0, 0.5), dvec3(0.5, 0.5, 0.5), dvec3(0.4, 0.4, 0.4)};
    const Diagram diagram{sites, unit_box};
    PredicateStats stats;
    CHECK(side1(diagram, 0, 1, dvec3(0.2, 0.9, 0), stats) == 1);
    CHECK(side1(diagram, 0, 1, dvec3(0.3, -0.9, 0), stats) == -1);
    CHECK(side2(diagram, 0, 1, 2, dvec3(0, 0.2, 0), dvec3(1, 0.2, 0), stats) == 1);
    CHECK(side2(diagram, 0, 1, 2, dvec3(0, 0.3, 0), dvec3(1, 0.3, 0), stats) == -1);
    const Corners low{dvec3(-1, -1, 0.2), dvec3(1, -1, 0.2), dvec3(0, 1, 0.2)};
    const Corners high{dvec3(-1, -1, 0.3), dvec3(1, -1, 0.3), dvec3(0, 1, 0.3)};
    CHECK(side3(diagram, 0, 1, 2, 3, low, stats) == 1);
    CHECK(side3(diagram, 0, 1, 2, 3, high, stats) == -1);
    CHECK(pierce_order(diagram, 0, 1, 2, low, high, stats) == -1);
    CHECK(pierce_order(diagram, 0, 2, 1, low, high, stats) == 1);
    CHECK(pierce_direction_exact(diagram, 0, 1, 2, low, stats) == 1);
    CHECK(pierce_direction_exact(diagram, 0, 1, 3, low, stats) == 0);
    CHECK(cell_vertex_orientation_exact(diagram, 0, 1, 2, 3, stats) == 1);
    CHECK(cell_vertex_orientation_exact(diagram, 0, 1, box_min_y, 3, stats) == -1);
    CHECK(cell_vertex_orientation_exact(diagram, 0, 1, box_min_x, 3, stats) == 0);
    CHECK(side4(diagram, 0, 1, 2, 3, 5, stats) == -1);
    CHECK(side4(diagram, 0, 1, 2, box_min_z, 5, stats) == 1);
    // The corner of the cube: site 4 is exactly as far away as the other four, and loses to site 0.
    CHECK(side4(diagram, 0, 1, 2, 3, 4, stats) == side4(diagram, 1, 0, 2, 3, 4, stats));
    CHECK(edge_parameter_exact(diagram, 0, 1, dvec3(0.0), dvec3(1, 0, 0)) == 0.25);
    CHECK(cell_vertex_exact(diagram, 0, 1, 2, 3) == dvec3(0.25));
    CHECK(cell_vertex_exact(diagram, 1, 0, 2, box_min_z) == dvec3(-0.25, 0.25, -1.0));
    const dvec3 weights = pierce_weights_exact(diagram, 0, 1, 2, low);
    CHECK(weights.x * low[0] + weights.y * low[1] + weights.z * low[2] == dvec3(0.25, 0.25, 0.2));
}

TEST_CASE("side1 agrees with rational arithmetic") {
    for (const Scene& scene : all_scenes()) {
        CAPTURE(scene.name);
        Draw draw{scene, Random(11)};
        const Diagram diagram{scene.sites, scene.box};
        PredicateStats stats;
        Tally tally;
        for (int i = 0; i < scene.cases; ++i) {
            const auto s = draw.sites(2);
            const dvec3 q = draw.point();
            const Expected e =
                expect(scene, s, tally, [&](const Oracle& o, Rational& r) { return o.side1(s[0], s[1], q, r); });
            REQUIRE(side1(diagram, s[0], s[1], q, stats) == e.sign);
            REQUIRE(side1_exact(diagram, s[0], s[1], q, stats) == e.sign);
            REQUIRE(side1(diagram, s[1], s[0], q, stats) == -e.sign);
        }
        CHECK(tally.ties == 0);
        CHECK(1000 * tally.perturbed >= scene.zeros * tally.asked);
    }
}

TEST_CASE("side2 agrees with rational arithmetic from both sites and both ends") {
    for (const Scene& scene : all_scenes()) {
        CAPTURE(scene.name);
        Draw draw{scene, Random(12)};
        const Diagram diagram{scene.sites, scene.box};
        PredicateStats stats;
        Tally tally;
        for (int i = 0; i < scene.cases; ++i) {
            const auto s = draw.sites(3);
            const dvec3 q0 = draw.point();
            const dvec3 q1 = draw.point();
            const Expected e = expect(
                scene, s, tally, [&](const Oracle& o, Rational& r) { return o.side2(s[0], s[1], s[2], q0, q1, r); });
            if (!e.exists()) continue;
            REQUIRE(side2(diagram, s[0], s[1], s[2], q0, q1, stats) == e.sign);
            REQUIRE(side2_exact(diagram, s[0], s[1], s[2], q0, q1, stats) == e.sign);
            REQUIRE(side2(diagram, s[1], s[0], s[2], q0, q1, stats) == e.sign);
            REQUIRE(side2(diagram, s[1], s[0], s[2], q1, q0, stats) == e.sign);
        }
        CHECK(tally.asked > scene.cases / 4);
        CHECK(tally.ties == 0);
        CHECK(1000 * tally.perturbed >= scene.zeros * tally.asked);
    }
}

TEST_CASE("side3 agrees with rational arithmetic from every site and corner order" * doctest::test_suite("long")) {
    for (const Scene& scene : all_scenes()) {
        CAPTURE(scene.name);
        Draw draw{scene, Random(13)};
        const Diagram diagram{scene.sites, scene.box};
        PredicateStats stats;
        Tally tally;
        for (int i = 0; i < scene.cases; ++i) {
            auto s = draw.sites(4);
            const Corners q = draw.corners();
            const Expected e = expect(
                scene, s, tally, [&](const Oracle& o, Rational& r) { return o.side3(s[0], s[1], s[2], s[3], q, r); });
            if (!e.exists()) {
                REQUIRE(pierce_direction_exact(diagram, s[0], s[1], s[2], q, stats) == 0);
                continue;
            }
            REQUIRE(pierce_direction_exact(diagram, s[0], s[1], s[2], q, stats) != 0);
            REQUIRE(side3(diagram, s[0], s[1], s[2], s[3], q, stats) == e.sign);
            std::sort(s.begin(), s.begin() + 3);
            do {
                REQUIRE(side3_exact(diagram, s[0], s[1], s[2], s[3], q, stats) == e.sign);
            } while (std::next_permutation(s.begin(), s.begin() + 3));
            REQUIRE(side3(diagram, s[2], s[0], s[1], s[3], {q[1], q[0], q[2]}, stats) == e.sign);
            REQUIRE(side3(diagram, s[1], s[0], s[2], s[3], {q[2], q[0], q[1]}, stats) == e.sign);
        }
        CHECK(tally.asked > scene.cases / 4);
        CHECK(tally.ties == 0);
        CHECK(1000 * tally.perturbed >= scene.zeros * tally.asked);
    }
}

TEST_CASE("side4 agrees with rational arithmetic from every site" * doctest::test_suite("long")) {
    for (const Scene& scene : all_scenes()) {
        CAPTURE(scene.name);
        Draw draw{scene, Random(14)};
        const Diagram diagram{scene.sites, scene.box};
        PredicateStats stats;
        Tally tally;
        for (int i = 0; i < scene.cases; ++i) {
            auto s = draw.sites(5);
            const SiteId l = s[4];
            s.pop_back();
            // In a third of the cases one to three sides of the box replace sites.
            const size_t box_planes = i % 3 == 0 ? 1 + (i / 3) % 3 : 0;
            for (size_t k = 0; k < box_planes; ++k) s[3 - k] = draw.box_plane();
            std::vector<SiteId> involved{l};
            for (const PlaneId p : s) {
                if (!is_box_plane(p)) involved.push_back(p);
            }
            const Expected e = expect(scene, involved, tally, [&](const Oracle& o, Rational& r) {
                return o.side4(s[0], s[1], s[2], s[3], l, r);
            });
            const int orientation = cell_vertex_orientation_exact(diagram, s[0], s[1], s[2], s[3], stats);
            REQUIRE((orientation != 0) == e.exists());
            if (!e.exists()) continue;
            REQUIRE(side4(diagram, s[0], s[1], s[2], s[3], l, stats) == e.sign);
            std::sort(s.begin(), s.end()); // sides of the box last, so the first is always a site
            do {
                if (is_box_plane(s[0])) continue;
                REQUIRE(side4_exact(diagram, s[0], s[1], s[2], s[3], l, stats) == e.sign);
                REQUIRE(side4(diagram, s[0], s[1], s[2], s[3], l, stats) == e.sign);
            } while (std::next_permutation(s.begin(), s.end()));
        }
        CHECK(tally.asked > scene.cases / 4);
        CHECK(tally.ties == 0);
        CHECK(1000 * tally.perturbed >= scene.zeros * tally.asked);
    }
}

TEST_CASE("pierce_order agrees with rational arithmetic and ties only in one plane") {
    for (const Scene& scene : all_scenes()) {
        CAPTURE(scene.name);
        Draw draw{scene, Random(15)};
        const Diagram diagram{scene.sites, scene.box};
        PredicateStats stats;
        Tally tally;
        for (int i = 0; i < scene.cases; ++i) {
            const auto s = draw.sites(3);
            const Corners q1 = draw.corners();
            Corners q2 = draw.corners();
            if (i % 3 == 1) q2[0] = q1[2];                     // a common corner
            if (i % 3 == 2) q2 = {q1[1], q1[0], draw.point()}; // a common edge
            const Expected e = expect(scene, s, tally, [&](const Oracle& o, Rational& r) {
                return o.pierce_order(s[0], s[1], s[2], q1, q2, r);
            });
            if (!e.exists()) continue;
            for (const auto& [c, a, b] : {std::array{s[0], s[1], s[2]}, {s[1], s[2], s[0]}, {s[2], s[0], s[1]}}) {
                REQUIRE(pierce_order(diagram, c, a, b, q1, q2, stats) == e.sign);
                REQUIRE(pierce_order_exact(diagram, c, a, b, q1, q2, stats) == e.sign);
                REQUIRE(pierce_order(diagram, c, b, a, q1, q2, stats) == -e.sign);
                REQUIRE(pierce_order(diagram, c, a, b, q2, q1, stats) == -e.sign);
            }
            if (e.sign == 0) {
                const Plane p1 = Oracle::plane(q1);
                for (const dvec3& q : q2) REQUIRE(dot(p1.n, vec(q)) == p1.k);
            }
        }
        CHECK(tally.asked > scene.cases / 4);
        CHECK(1000 * tally.perturbed >= scene.zeros * tally.asked);
    }
}

// Each predicate is a quotient of two determinants. The perturbed numerator changes sign whenever any two of its sites
// are exchanged, the queried one included. This relates the answers for different points.
TEST_CASE("numerators are antisymmetric in all their sites") {
    for (const Scene& scene : all_scenes()) {
        CAPTURE(scene.name);
        Draw draw{scene, Random(17)};
        const Diagram diagram{scene.sites, scene.box};
        PredicateStats stats;
        for (int i = 0; i < 40; ++i) {
            const auto s = draw.sites(5);
            const Corners q = draw.corners();
            const auto numerator = [&](const std::array<int, 5>& p, int count) {
                const std::array<SiteId, 5> t{s[p[0]], s[p[1]], s[p[2]], s[p[3]], s[p[4]]};
                if (count == 5) {
                    const int w = cell_vertex_orientation_exact(diagram, t[0], t[1], t[2], t[3], stats);
                    return w == 0 ? 0 : w * side4(diagram, t[0], t[1], t[2], t[3], t[4], stats);
                }
                const int w = pierce_direction_exact(diagram, t[0], t[1], t[2], q, stats);
                return w == 0 ? 0 : w * side3(diagram, t[0], t[1], t[2], t[3], q, stats);
            };
            for (const int count : {4, 5}) {
                std::array<int, 5> p{0, 1, 2, 3, 4};
                int expected = 0; // sign of the identity, known from the first order with a point
                do {
                    int inversions = 0;
                    for (int a = 0; a < count; ++a) {
                        for (int b = a + 1; b < count; ++b) inversions += p[a] > p[b];
                    }
                    const int sign = (inversions % 2 ? -1 : 1) * numerator(p, count);
                    if (expected == 0) expected = sign;
                    if (sign != 0) REQUIRE(sign == expected);
                } while (std::next_permutation(p.begin(), p.begin() + count));
            }
        }
    }
}

TEST_CASE("the nearest site by side1 is a total order of the sites at every point") {
    Random random(3);
    const Scene scene = lattice_scene(random, 1);
    const Diagram diagram{scene.sites, scene.box};
    PredicateStats stats;
    for (const dvec3& q : scene.points) {
        std::vector<int> beaten;
        for (SiteId c = 0; c < scene.sites.size(); ++c) {
            int count = 0;
            for (SiteId l = 0; l < scene.sites.size(); ++l) {
                if (l != c) count += side1(diagram, c, l, q, stats) > 0;
            }
            beaten.push_back(count);
        }
        std::sort(beaten.begin(), beaten.end());
        for (size_t i = 0; i < beaten.size(); ++i) REQUIRE(beaten[i] == static_cast<int>(i));
    }
}
