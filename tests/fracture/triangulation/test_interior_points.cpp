#include "fracture/triangulation/interior_points.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

using namespace brittle::fracture;

namespace {

double doubled_area(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

double distance_to_segment(const glm::dvec2& p, const glm::dvec2& a, const glm::dvec2& b) {
    const glm::dvec2 d = b - a;
    return glm::distance(p, a + std::clamp(glm::dot(p - a, d) / glm::dot(d, d), 0.0, 1.0) * d);
}

struct Region {
    std::vector<glm::dvec2> points;
    std::vector<Loop> loops;
};

// Adds a loop of points, turned by an angle, so that nothing is parallel to an axis.
void add_loop(Region& region, const std::vector<glm::dvec2>& corners, double angle) {
    Loop loop;
    for (const glm::dvec2& p : corners) {
        loop.push_back(static_cast<uint32_t>(region.points.size()));
        region.points.push_back(
            {std::cos(angle) * p.x - std::sin(angle) * p.y, std::sin(angle) * p.x + std::cos(angle) * p.y});
    }
    region.loops.push_back(loop);
}

// Returns the count of new points.
size_t check_region(Region region, double spacing) {
    Triangulator triangulator;
    const Triangulation& flat = triangulator.run(region.points, region.loops);
    REQUIRE(flat.forced_ears == 0);
    std::vector<Triangle> triangles(flat.triangles.begin(), flat.triangles.end());
    double before = 0.0, after = 0.0;
    for (const Triangle& t : triangles)
        before += doubled_area(region.points[t.x], region.points[t.y], region.points[t.z]);

    const size_t border = region.points.size();
    const std::vector<InteriorPoints::Normals> normals(border);
    InteriorPoints inserter;
    inserter.run(region.loops, spacing, normals, region.points, triangles);

    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    for (const Triangle& t : triangles) {
        const double area = doubled_area(region.points[t.x], region.points[t.y], region.points[t.z]);
        CHECK(area > 0.0);
        after += area;
        for (int k = 0; k < 3; ++k) CHECK(++edges[{t[k], t[(k + 1) % 3]}] == 1);
    }
    CHECK(after == doctest::Approx(before).epsilon(1e-12));
    for (const Loop& loop : region.loops)
        for (size_t k = 0; k < loop.size(); ++k) {
            const uint32_t a = loop[k], b = loop[(k + 1) % loop.size()];
            CHECK(edges.count({a, b}) == 1);
            CHECK(edges.count({b, a}) == 0);
            for (size_t p = border; p < region.points.size(); ++p)
                CHECK(distance_to_segment(region.points[p], region.points[a], region.points[b]) > 0.29 * spacing);
        }
    for (size_t p = border; p < region.points.size(); ++p)
        for (size_t q = 0; q < p; ++q) CHECK(glm::distance(region.points[p], region.points[q]) > 0.59 * spacing);
    return region.points.size() - border;
}

} // namespace

TEST_CASE("interior points: off the border, each edge of it kept, triangles positive and the area whole") {
    for (const double angle : {0.0, 0.1, 0.7, 1.5707963267948966, 2.3}) {
        CAPTURE(angle);
        Region square, ell, frame, needle, thin;
        add_loop(square, {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, angle);
        add_loop(ell, {{0, 0}, {2, 0}, {2, 0.5}, {0.5, 0.5}, {0.5, 2}, {0, 2}}, angle);
        add_loop(frame, {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, angle);
        add_loop(frame, {{0.3, 0.3}, {0.3, 0.7}, {0.7, 0.7}, {0.7, 0.3}}, angle);
        add_loop(needle, {{0, 0}, {5, 0}, {5, 0.6}}, angle);
        add_loop(thin, {{0, 0}, {5, 0}, {5, 0.05}, {0, 0.05}}, angle);
        // Long edges have few points of their own: only the distance from the edges keeps the lattice off them.
        for (const double spacing : {0.3, 0.1, 0.037}) {
            CAPTURE(spacing);
            CHECK(check_region(square, spacing) > 0.3 / (spacing * spacing));
            CHECK(check_region(ell, spacing) > 0.3 / (spacing * spacing));
            check_region(frame, spacing);
            check_region(needle, spacing);
            if (spacing >= 0.1) CHECK(check_region(thin, spacing) == 0);
        }
    }
}

TEST_CASE("interior points: a spacing larger than the region, and one far too small, add nothing") {
    Region square;
    add_loop(square, {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, 0.3);
    CHECK(check_region(square, 10.0) == 0);
    CHECK(check_region(square, 1e-9) == 0);
}
