#include "fracture/triangulation/simple_loop.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "fracture/base/random.h"
#include "fracture/triangulation/triangulate.h"

using namespace brittle::fracture;

namespace {

double area(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return 0.5 * ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
}

double area(const std::vector<glm::dvec2>& loop) {
    double sum = 0.0;
    for (size_t k = 2; k < loop.size(); ++k) sum += area(loop[0], loop[k - 1], loop[k]);
    return sum;
}

// A star-shaped polygon with random radii between `least` and 1: simple, mostly concave.
std::vector<glm::dvec2> star(uint32_t n, uint64_t seed, double least) {
    Random random(seed);
    std::vector<glm::dvec2> loop;
    for (uint32_t k = 0; k < n; ++k) {
        const double angle = 2.0 * 3.14159265358979 * k / n, r = least + (1.0 - least) * random.uniform();
        loop.push_back({r * std::cos(angle), r * std::sin(angle)});
    }
    return loop;
}

Loop ids(size_t count, uint32_t first = 0) {
    Loop loop(count);
    std::iota(loop.begin(), loop.end(), first);
    return loop;
}

void check_triangulation(const std::vector<glm::dvec2>& loop) {
    triangulation::SimpleLoop simple;
    std::vector<Triangle> triangles{{9, 9, 9}};
    constexpr uint32_t first = 100;
    REQUIRE(simple.triangulate(loop, ids(loop.size(), first), triangles));
    REQUIRE(triangles.size() == loop.size() - 1); // one was there before
    std::map<std::pair<uint32_t, uint32_t>, int> uses;
    double sum = 0.0;
    for (size_t t = 1; t < triangles.size(); ++t) {
        const Triangle corners = triangles[t] - first;
        const double piece = area(loop[corners.x], loop[corners.y], loop[corners.z]);
        CHECK(piece > 0.0);
        sum += piece;
        for (int k = 0; k < 3; ++k) ++uses[{corners[k], corners[(k + 1) % 3]}];
    }
    CHECK(sum == doctest::Approx(area(loop)));
    for (const auto& [edge, count] : uses) {
        CHECK(count == 1);
        const bool side = edge.second == (edge.first + 1) % loop.size();
        CHECK(uses.count({edge.second, edge.first}) == (side ? 0 : 1));
    }
    for (uint32_t k = 0; k < loop.size(); ++k) {
        CHECK(uses.count({k, (k + 1) % static_cast<uint32_t>(loop.size())}) == 1);
    }
}

bool is_refused(const std::vector<glm::dvec2>& loop) {
    triangulation::SimpleLoop simple;
    std::vector<Triangle> triangles{{9, 9, 9}};
    const bool done = simple.triangulate(loop, ids(loop.size()), triangles);
    return !done && triangles.size() == 1;
}

} // namespace

TEST_CASE("simple loop: refuses a doubtful loop and appends nothing") {
    CHECK(is_refused({{0, 0}, {1, 0}, {2, 0}}));                    // no area
    CHECK(is_refused({{0, 0}, {0, 1}, {1, 0}}));                    // clockwise
    CHECK(is_refused({{0, 0}, {1, 0}, {2, 0}, {1, 1}}));            // collinear
    CHECK(is_refused({{0, 0}, {1, 0}, {1, 0}, {0, 1}}));            // a point twice
    CHECK(is_refused({{0, 0}, {1, 1}, {1, 0}, {0, 1}}));            // crosses itself
    CHECK(is_refused({{0, 0}, {1, 0}, {0.5, 1e-17}, {0.5, -1.0}})); // flat to rounding
    std::vector<glm::dvec2> backwards = star(40, 3, 0.5);
    std::reverse(backwards.begin(), backwards.end());
    CHECK(is_refused(backwards));
    CHECK(is_refused(star(400, 5, 0.1))); // too many concave vertices for the fast path
}

TEST_CASE("simple loop: triangulates triangles, quads, convex and star-shaped loops") {
    check_triangulation({{0, 0}, {1, 0}, {0, 1}});
    check_triangulation({{0, 0}, {2, 0}, {2, 1}, {0, 1}});
    check_triangulation({{0, 0}, {1, 0.1}, {2, 0}, {1, 3}});
    for (uint64_t seed = 1; seed <= 30; ++seed) {
        CAPTURE(seed);
        check_triangulation(star(5 + static_cast<uint32_t>(seed) * 2, seed, 0.2));
    }
    check_triangulation(star(300, 1, 1.0)); // a circle
}

TEST_CASE("simple loop: flips a diagonal to the shorter one of a kite") {
    triangulation::SimpleLoop simple;
    for (uint32_t turn = 0; turn < 4; ++turn) {
        std::vector<glm::dvec2> kite{{0, -1}, {5, 0}, {0, 1}, {-5, 0}};
        std::rotate(kite.begin(), kite.begin() + turn, kite.end());
        std::vector<Triangle> triangles;
        REQUIRE(simple.triangulate(kite, ids(kite.size()), triangles));
        for (const Triangle& t : triangles) {
            int near_axis = 0;
            for (int k = 0; k < 3; ++k) near_axis += std::abs(kite[t[k]].x) < 1.0 ? 1 : 0;
            CHECK(near_axis == 2);
        }
    }
}

TEST_CASE("simple loop: run_simple() leaves a region with a hole to run()") {
    const std::vector<glm::dvec2> points{{0, 0}, {3, 0}, {3, 3}, {0, 3}, {1, 1}, {1, 2}, {2, 2}, {2, 1}};
    const std::vector<Loop> square{{0, 1, 2, 3}}, frame{{0, 1, 2, 3}, {4, 5, 6, 7}};
    Triangulator triangulator;
    CHECK(triangulator.run_simple(points, square).triangles.size() == 2);
    const Triangulation expected = triangulator.run(points, frame);
    CHECK(expected.triangles.size() == 8);
    CHECK(triangulator.run_simple(points, frame).triangles == expected.triangles);
}
