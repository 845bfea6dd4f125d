#include "fracture/mesh/manifold_check.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "fracture/base/random.h"
#include "fracture/mesh/topology.h"
#include "fracture/shapes/shapes.h"

using namespace brittle::fracture;

namespace {

using Triangles = std::vector<Triangle>;

// Checks the answers of a new and of a reused checker, with one thread and with three.
bool check(size_t vertices, const Triangles& triangles) {
    static ManifoldCheck used;
    static Threads three(3);
    Threads one;
    ManifoldCheck fresh;
    const bool answer = fresh.run(vertices, triangles, one);
    CHECK(used.run(vertices, triangles, one) == answer);
    CHECK(used.run(vertices, triangles, three) == answer);
    return answer;
}

// A double pyramid over a ring of n vertices: both poles have degree n.
Triangles double_pyramid(uint32_t n) {
    Triangles triangles;
    for (uint32_t k = 0; k < n; ++k) {
        const uint32_t a = 2 + k, b = 2 + (k + 1) % n;
        triangles.push_back({0, a, b});
        triangles.push_back({1, b, a});
    }
    return triangles;
}

// Permutes the vertices, the triangles and the first corner of each triangle.
Triangles shuffled(Triangles triangles, uint32_t vertices, Random& random) {
    std::vector<uint32_t> number(vertices);
    for (uint32_t v = 0; v < vertices; ++v) number[v] = v;
    for (uint32_t v = vertices; v > 1; --v) std::swap(number[v - 1], number[random.next() % v]);
    for (size_t t = triangles.size(); t > 1; --t) std::swap(triangles[t - 1], triangles[random.next() % t]);
    for (Triangle& t : triangles) {
        t = {number[t.x], number[t.y], number[t.z]};
        for (uint64_t turns = random.next() % 3; turns > 0; --turns) t = {t.y, t.z, t.x};
    }
    return triangles;
}

} // namespace

TEST_CASE("manifold check: no triangles, bad indices and degenerate triangles") {
    CHECK(check(0, {}));
    CHECK(check(5, {}));
    CHECK_FALSE(check(0, {{0, 1, 2}}));
    CHECK_FALSE(check(3, {{0, 1, 2}, {0, 2, 3}}));
    CHECK_FALSE(check(3, {{0, 1, 2}, {0, 2, 0xffffffffu}}));
    CHECK_FALSE(check(3, {{0, 1, 2}}));
    CHECK(check(3, {{0, 1, 2}, {0, 2, 1}}));
    CHECK_FALSE(check(3, {{0, 1, 2}, {0, 2, 1}, {1, 1, 2}}));
    CHECK_FALSE(check(3, {{0, 0, 0}}));
    CHECK_FALSE(check(3, {{0, 1, 2}, {0, 1, 2}}));
    CHECK_FALSE(check(3, {{0, 1, 2}, {0, 2, 1}, {0, 1, 2}, {0, 2, 1}}));
}

TEST_CASE("manifold check: shapes pass, and fail with any one triangle missing, doubled or reversed") {
    for (const std::string_view name : shape_names()) {
        CAPTURE(name);
        const TriangleMesh mesh = *shape(name);
        const size_t vertices = mesh.positions.size();
        CHECK(check(vertices, mesh.triangles));
        Random random(3);
        for (int round = 0; round < 10; ++round) {
            const size_t t = random.next() % mesh.triangles.size();
            Triangles missing = mesh.triangles;
            missing.erase(missing.begin() + static_cast<std::ptrdiff_t>(t));
            CHECK_FALSE(check(vertices, missing));
            Triangles doubled = mesh.triangles;
            doubled.push_back(doubled[t]);
            CHECK_FALSE(check(vertices, doubled));
            Triangles turned = mesh.triangles;
            std::swap(turned[t].x, turned[t].z);
            CHECK_FALSE(check(vertices, turned));
        }
    }
}

TEST_CASE("manifold check: vertices of any degree, with one or two fans") {
    Random random(5);
    for (const uint32_t n : {3u, 4u, 7u, 8u, 9u, 10u, 24u, 1000u}) {
        CAPTURE(n);
        const Triangles triangles = shuffled(double_pyramid(n), n + 2, random);
        CHECK(check(n + 2, triangles));
        for (size_t t = 0; t < triangles.size(); t += 1 + triangles.size() / 20) {
            Triangles missing = triangles;
            missing.erase(missing.begin() + static_cast<std::ptrdiff_t>(t));
            CHECK_FALSE(check(n + 2, missing));
        }
        // Two double pyramids with a common pole: every edge is paired, but the pole has two fans.
        Triangles touching = double_pyramid(n);
        for (const Triangle& t : double_pyramid(n)) {
            const auto other = [&](uint32_t v) { return v == 0 ? 0 : v + n + 1; };
            touching.push_back({other(t.x), other(t.y), other(t.z)});
        }
        const TopologyReport report = check_topology(2 * n + 3, touching);
        REQUIRE(report.closed());
        REQUIRE_FALSE(report.manifold());
        CHECK_FALSE(check(2 * n + 3, shuffled(touching, 2 * n + 3, random)));
    }
}

TEST_CASE("manifold check: agrees with check_topology() on random soups and on shuffled, damaged spheres") {
    Random random(11);
    int sound = 0;
    for (int round = 0; round < 3000; ++round) {
        const auto vertices = static_cast<uint32_t>(3 + random.next() % 6);
        Triangles soup(2 + 2 * (random.next() % 4));
        for (Triangle& t : soup)
            for (int k = 0; k < 3; ++k) t[k] = static_cast<uint32_t>(random.next() % vertices);
        if (round % 2 == 0) // pairs of opposite triangles are often closed
            for (size_t t = 1; t < soup.size(); t += 2) soup[t] = {soup[t - 1].x, soup[t - 1].z, soup[t - 1].y};
        const bool manifold = check_topology(vertices, soup).manifold();
        sound += manifold;
        CHECK(check(vertices, soup) == manifold);
    }
    CHECK(sound > 50);
    const TriangleMesh ball = icosphere(4);
    const auto vertices = static_cast<uint32_t>(ball.positions.size());
    for (int round = 0; round < 60; ++round) {
        Triangles triangles = shuffled(ball.triangles, vertices, random);
        CHECK(check(vertices, triangles));
        // Swaps two corners, which nearly always causes a fault, of any kind.
        Triangle &a = triangles[random.next() % triangles.size()], &b = triangles[random.next() % triangles.size()];
        std::swap(a[static_cast<int>(random.next() % 3)], b[static_cast<int>(random.next() % 3)]);
        CHECK(check(vertices, triangles) == check_topology(vertices, triangles).manifold());
    }
}
