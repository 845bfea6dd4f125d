// Ranges, error bounds and constructions of the exact predicates.
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

TEST_CASE("answers hold at the ends of the documented range of coordinates") {
    Random random(4);
    // Exponents vary between the granularity and the largest coordinate within one query.
    const auto coordinate = [&] {
        const int exponent = static_cast<int>(random.next() % 251) - 150;
        double x = std::ldexp(static_cast<double>(random.next() >> 11) * 0x1.0p-53, exponent);
        if (random.next() % 3 == 0) x = std::ldexp(1.0, exponent);
        if (random.next() % 8 == 0) x = 0.0;
        x = snap(x);
        return random.next() % 2 ? x : -x;
    };
    const auto point = [&] {
        const double x = coordinate();
        const double y = coordinate();
        return dvec3(x, y, coordinate());
    };
    PredicateStats stats;
    int asked = 0;
    for (int i = 0; i < 300; ++i) {
        std::vector<dvec3> sites;
        for (int k = 0; k < 5; ++k) sites.push_back(point());
        const Diagram diagram{sites, {dvec3(-max_coordinate), dvec3(max_coordinate)}};
        const Corners q1{point(), point(), point()};
        const Corners q2{q1[0], point(), point()};
        const Oracle oracle{&diagram, {}, 0};
        Rational r;
        const auto check = [&](bool exists, auto&& predicate, auto&& exact_predicate) {
            if (!exists || r == 0) return;
            ++asked;
            REQUIRE(predicate() == r.sign());
            REQUIRE(exact_predicate() == r.sign());
        };
        check(
            oracle.side1(0, 1, q1[0], r), [&] { return side1(diagram, 0, 1, q1[0], stats); },
            [&] { return side1_exact(diagram, 0, 1, q1[0], stats); });
        check(
            oracle.side2(0, 1, 2, q1[0], q1[1], r), [&] { return side2(diagram, 0, 1, 2, q1[0], q1[1], stats); },
            [&] { return side2_exact(diagram, 0, 1, 2, q1[0], q1[1], stats); });
        check(
            oracle.side3(0, 1, 2, 3, q1, r), [&] { return side3(diagram, 0, 1, 2, 3, q1, stats); },
            [&] { return side3_exact(diagram, 0, 1, 2, 3, q1, stats); });
        check(
            oracle.side4(0, 1, 2, 3, 4, r), [&] { return side4(diagram, 0, 1, 2, 3, 4, stats); },
            [&] { return side4_exact(diagram, 0, 1, 2, 3, 4, stats); });
        check(
            oracle.pierce_order(0, 1, 2, q1, q2, r), [&] { return pierce_order(diagram, 0, 1, 2, q1, q2, stats); },
            [&] { return pierce_order_exact(diagram, 0, 1, 2, q1, q2, stats); });
    }
    CHECK(asked > 1000);
}

TEST_CASE("the error bounds of values and pierce positions contain the true error") {
    Random random(5);
    double worst_value = 0.0;
    double worst_pierce = 0.0;
    for (int i = 0; i < 2000; ++i) {
        // Far from the origin, differences have few bits; near it they are rounded.
        const double offset = i % 2 ? 0.0 : 1e3;
        const double size = i % 3 ? 1.0 : 1e-3;
        const auto point = [&] { return (random.uniform_in(unit_box) + offset) * size; };
        const std::vector<dvec3> sites{point(), point(), point()};
        const Diagram diagram{sites, unit_box};
        const Oracle oracle{&diagram, {}, 0};
        const Bisector a = make_bisector(sites[0], sites[1]);
        const Bisector b = make_bisector(sites[0], sites[2]);
        const Corners q{point(), point(), point()};
        Corners y;
        double reach = 0.0;
        dvec3 va, vb;
        for (int k = 0; k < 3; ++k) {
            y[k] = q[k] - sites[0];
            reach = std::max(reach, glm::length(y[k]));
        }
        const double error = value_error(std::max(a.length, b.length), reach);
        for (int k = 0; k < 3; ++k) {
            va[k] = value(a, y[k]);
            vb[k] = value(b, y[k]);
            const Rational difference = abs(Rational(va[k]) - oracle.g(0, 1, vec(q[k])) / 2);
            REQUIRE(difference <= Rational(error));
            worst_value = std::max(worst_value, static_cast<double>(difference) / error);
        }
        const PiercePosition p = pierce_position(a, b, y, va, vb, error);
        if (!std::isfinite(p.error)) continue;
        Vec x;
        REQUIRE(meet(oracle.plane(0, 1), oracle.plane(0, 2), Oracle::plane(q), x));
        const Vec d = cross(vec(sites[1]) - vec(sites[0]), vec(sites[2]) - vec(sites[0]));
        const Rational difference = abs(Rational(p.t) - dot(x - vec(sites[0]), d));
        REQUIRE(difference <= Rational(p.error));
        worst_pierce = std::max(worst_pierce, static_cast<double>(difference) / p.error);
    }
    // The bounds are not needlessly wide.
    CHECK(worst_value > 0.05);
    CHECK(worst_pierce > 0.005);
}

TEST_CASE("the error bound of a pierce position contains what values within their error make of it") {
    Random random(51);
    constexpr double error = 1e-4; // far above rounding
    double worst = 0.0;
    for (int i = 0; i < 2000; ++i) {
        const auto point = [&] { return random.uniform_in(unit_box) * 2.0 - 1.0; };
        const Bisector a = make_bisector(point(), point()), b = make_bisector(point(), point());
        const dvec3 d = glm::cross(a.n, b.n);
        // In half of the cases an edge of the triangle is across the line, so that the third corner alone moves along it.
        const dvec3 from = point(), way = point();
        const Corners y{from, i % 2 ? from + glm::cross(d, way) : point(), point()};
        const dvec3 va = point();
        // The line passes near that edge: c2 is about 0.
        const double share = random.uniform_in(unit_box).x;
        const dvec3 vb = i % 4 < 2 ? dvec3(share * va.x, share * va.y, point().z) : point();
        const PiercePosition exact = pierce_position(a, b, y, va, vb, 0.0);
        const auto wrong = [&] { return random.next() % 2 ? error : -error; };
        const dvec3 wa = va + dvec3(wrong(), wrong(), wrong()), wb = vb + dvec3(wrong(), wrong(), wrong());
        const PiercePosition found = pierce_position(a, b, y, wa, wb, error);
        if (!std::isfinite(found.error)) continue;
        REQUIRE(std::abs(found.t - exact.t) <= found.error + exact.error);
        worst = std::max(worst, std::abs(found.t - exact.t) / found.error);
    }
    CHECK(worst > 0.05);
}

TEST_CASE("with exact values the filter of three bisectors answers no wrong sign, however small the determinant") {
    Random random(52);
    int decided = 0;
    for (int i = 0; i < 4000; ++i) {
        const double scale = std::ldexp(1.0, static_cast<int>(random.next() % 61) - 30);
        const auto values = [&] { return (random.uniform_in(unit_box) * 2.0 - 1.0) * scale; };
        const dvec3 a = values(), l = values();
        // b lies in the plane of a and (1, 1, 1) but for rounding, or a little above it.
        const dvec3 weights = random.uniform_in(unit_box);
        dvec3 b = weights.x * a + dvec3(weights.y * scale);
        if (i % 2) b += values() * std::ldexp(1.0, -static_cast<int>(random.next() % 60));
        const int sign = side3_filter(a, b, l, 0.0);
        if (sign == 0) continue;
        ++decided;
        const Vec minors = cross(vec(a), vec(b));
        const Rational numerator = dot(vec(l), minors), denominator = minors.x + minors.y + minors.z;
        REQUIRE(numerator.sign() * denominator.sign() == sign);
    }
    CHECK(decided > 500);
}

TEST_CASE("on random input the filters decide all but a few signs in ten thousand") {
    Random random(6);
    Scene scene = random_scene(random);
    const Diagram diagram{scene.sites, scene.box};
    Draw draw{scene, Random(16)};
    PredicateStats stats;
    constexpr int rounds = 20000;
    for (int i = 0; i < rounds; ++i) {
        const auto s = draw.sites(5);
        const Corners q = draw.corners();
        const Corners r = draw.corners();
        if (q[0] == q[1] || q[1] == q[2] || q[0] == q[2] || r[0] == r[1] || r[1] == r[2] || r[0] == r[2] || q == r) {
            continue;
        }
        int sum = side1(diagram, s[0], s[1], q[0], stats) + side2(diagram, s[0], s[1], s[2], q[0], q[1], stats)
                  + side3(diagram, s[0], s[1], s[2], s[3], q, stats)
                  + side4(diagram, s[0], s[1], s[2], s[3], s[4], stats);
        (void)sum;
        (void)pierce_order(diagram, s[0], s[1], s[2], q, r, stats);
    }
    CHECK(stats.side1_exact <= 2);
    CHECK(stats.side2_exact <= 4);
    CHECK(stats.side3_exact <= 8);
    CHECK(stats.side4_exact <= 8);
    CHECK(stats.pierce_exact <= 200); // includes triangles with a common corner on the line
}

TEST_CASE("exact constructions are within a few ulp of the true positions, however ill-conditioned") {
    Random random(8);
    for (int i = 0; i < 500; ++i) {
        // Sites almost on a line, whose bisectors are almost dependent.
        const dvec3 base = random.uniform_in(unit_box);
        const dvec3 step = random.uniform_in(unit_box) * 0.1;
        std::vector<dvec3> sites;
        const double noise = std::ldexp(1.0, -static_cast<int>(random.next() % 45));
        for (int k = 0; k < 4; ++k)
            sites.push_back(base + static_cast<double>(k) * step + random.uniform_in(unit_box) * noise);
        const Diagram diagram{sites, unit_box};
        const Oracle oracle{&diagram, {}, 0};
        const auto close = [](double x, const Rational& exact, const Rational& scale) {
            return abs(Rational(x) - exact) <= scale * Rational(0x10.0p-53);
        };
        Vec x;
        if (meet(oracle.plane(0, 1), oracle.plane(0, 2), oracle.plane(0, 3), x)) {
            x = x - vec(sites[0]);
            const dvec3 v = cell_vertex_exact(diagram, 0, 1, 2, 3);
            REQUIRE(close(v.x, x.x, abs(x.x)));
            REQUIRE(close(v.y, x.y, abs(x.y)));
            REQUIRE(close(v.z, x.z, abs(x.z)));
        }
        const dvec3 q0 = random.uniform_in(unit_box);
        const dvec3 q1 = random.uniform_in(unit_box);
        const Rational f0 = oracle.g(0, 1, vec(q0));
        const Rational f1 = oracle.g(0, 1, vec(q1));
        if (f0.sign() * f1.sign() < 0) {
            const Rational t = f0 / (f0 - f1);
            REQUIRE(close(edge_parameter_exact(diagram, 0, 1, q0, q1), t, t));
        }
        const Corners q{q0, q1, random.uniform_in(unit_box)};
        if (meet(oracle.plane(0, 1), oracle.plane(0, 2), Oracle::plane(q), x)) {
            const dvec3 w = pierce_weights_exact(diagram, 0, 1, 2, q);
            if (w.x == 0.0 || w.y == 0.0 || w.z == 0.0) continue; // clamped: the pierce point is outside the triangle
            const Vec p = vec(w.x * q[0] + w.y * q[1] + w.z * q[2]);
            REQUIRE(close(0.0, p.x - x.x, 1));
            REQUIRE(close(0.0, p.y - x.y, 1));
            REQUIRE(close(0.0, p.z - x.z, 1));
        }
    }
}
