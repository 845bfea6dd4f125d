#include "fracture/mesh/convex_hull.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/mesh/intersections.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/topology.h"
#include "fracture/shapes/shapes.h"

using namespace brittle;
using namespace brittle::fracture;

namespace {

double volume_of(const TriangleMesh& mesh) {
    return signed_volume(mesh.positions, mesh.triangles);
}

// A closed surface of some of the points whose triangles have all points behind them is their convex hull.
void check_hull(const TriangleMesh& hull, std::span<const glm::dvec3> points) {
    CHECK(check_topology(hull.positions.size(), hull.triangles).manifold());
    size_t at = 0; // the vertices are points, in their order
    for (const glm::dvec3& p : points)
        if (at < hull.positions.size() && p == hull.positions[at]) ++at;
    CHECK(at == hull.positions.size());
    uint64_t outside = 0;
    for (const Triangle& t : hull.triangles)
        for (const glm::dvec3& p : points)
            if (orientation(hull.positions[t.x], hull.positions[t.y], hull.positions[t.z], p) < 0) ++outside;
    CHECK(outside == 0);
}

std::vector<glm::dvec3> random_points(size_t count, uint64_t seed) {
    Random random(seed);
    std::vector<glm::dvec3> points;
    while (points.size() < count) points.push_back(random.uniform_in({glm::dvec3(-1.0), glm::dvec3(1.0)}));
    return points;
}

} // namespace

TEST_CASE("convex_hull(): points in one plane have none") {
    using Points = std::vector<glm::dvec3>;
    const auto is_empty = [](const Points& points) {
        const TriangleMesh hull = convex_hull(points);
        return hull.positions.empty() && hull.triangles.empty();
    };
    CHECK(is_empty({}));
    CHECK(is_empty({glm::dvec3(1.0), glm::dvec3(2.0), glm::dvec3(3.0, 0.0, 0.0)}));
    CHECK(is_empty(Points(100, glm::dvec3(0.1, 0.2, 0.3))));
    Points line, plane;
    for (int i = 0; i < 50; ++i) {
        line.push_back(static_cast<double>(i) * glm::dvec3(0.25, 0.5, -0.125));
        plane.emplace_back(i % 7, i / 7, 3.0 * (i % 7) - 2.0 * (i / 7)); // exact
    }
    CHECK(is_empty(line));
    CHECK(is_empty(plane));
    plane.push_back(plane[10] + glm::dvec3(0.0, 0.0, 1e-14));
    CHECK(volume_of(convex_hull(plane)) > 0.0);
    check_hull(convex_hull(plane), plane);
}

TEST_CASE("convex_hull(): coordinates out of range have none, whatever the others are") {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), infinity, -infinity, 1e51, -1e51, 1e-71, -1e-200,
                             std::numeric_limits<double>::denorm_min()}) {
        CAPTURE(bad);
        for (int axis = 0; axis < 3; ++axis) {
            std::vector<glm::dvec3> points = random_points(50, 8);
            for (size_t k = 7; k < points.size(); k += 11) points[k][axis] = bad;
            CHECK(convex_hull(points).triangles.empty());
        }
    }
    std::vector<glm::dvec3> small = random_points(50, 9), large = small;
    for (glm::dvec3& p : small) p *= 1e-66;
    for (glm::dvec3& p : large) p *= 1e50;
    check_hull(convex_hull(large), large);
    check_hull(convex_hull(small), small);
    CHECK(!convex_hull(small).triangles.empty());
    // All single precision is in range but what is not finite.
    std::vector<glm::vec3> tiny, huge;
    for (const glm::dvec3& p : random_points(50, 10)) {
        tiny.push_back(glm::vec3(p * 1e-43)); // denormal, most of them equal in a coordinate
        huge.push_back(glm::vec3(p * 3e38));
    }
    CHECK(!convex_hull(tiny).triangles.empty());
    CHECK(!convex_hull(huge).triangles.empty());
    huge.front().y = std::numeric_limits<float>::infinity();
    CHECK(convex_hull(huge).triangles.empty());
}

TEST_CASE("convex_hull(): points on the faces and edges of a cube") {
    for (const uint32_t n : {1u, 2u, 7u}) {
        const TriangleMesh lattice = lattice_cube(n);
        const TriangleMesh hull = convex_hull(lattice.positions);
        check_hull(hull, lattice.positions);
        CHECK(volume_of(hull) == 8.0);
    }
    // A turned cube, whose faces are planes up to rounding; all points twice.
    std::vector<glm::dvec3> turned;
    for (const glm::dvec3& p : lattice_cube(9).positions)
        for (int copy = 0; copy < 2; ++copy)
            turned.emplace_back(0.6 * p.x - 0.8 * p.y, 0.8 * p.x + 0.6 * p.y, p.z / 3.0);
    const TriangleMesh hull = convex_hull(turned);
    check_hull(hull, turned);
    CHECK(volume_of(hull) == doctest::Approx(8.0 / 3.0).epsilon(1e-14));
}

TEST_CASE("convex_hull(): every point of a convex surface is a corner, and none inside it") {
    TriangleMesh ball = icosphere(4, 0.7);
    const double volume = volume_of(ball);
    const size_t corners = ball.positions.size();
    for (const glm::dvec3& p : random_points(500, 3)) ball.positions.push_back(0.3 * p);
    const TriangleMesh hull = convex_hull(ball.positions);
    check_hull(hull, ball.positions);
    CHECK(hull.positions.size() == corners);
    CHECK(volume_of(hull) == doctest::Approx(volume).epsilon(1e-14));
}

TEST_CASE("convex_hull(): random, flat, long, tiny and far points") {
    for (uint64_t seed = 0; seed < 60; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        std::vector<glm::dvec3> points = random_points(4 + 3 * seed, seed);
        const glm::dvec3 scale(1.0, std::pow(10.0, -15.0 * random.uniform()), std::pow(10.0, -15.0 * random.uniform()));
        const double size = std::pow(10.0, 60.0 * random.uniform() - 30.0);
        for (glm::dvec3& p : points) {
            if (seed % 3 == 0) p = glm::normalize(p);
            if (seed % 4 == 1) p = glm::round(p * 3.0); // many are equal, in line or in a plane
            if (seed % 5 == 2) p += glm::dvec3(1e6, -2e7, 3e8);
            p *= size;
            if (seed % 2 == 0) p *= scale;
        }
        const TriangleMesh hull = convex_hull(points);
        check_hull(hull, points);
        CHECK(!hull.triangles.empty());
        const std::vector<glm::vec3> single(points.begin(), points.end());
        check_hull(convex_hull(single), std::vector<glm::dvec3>(single.begin(), single.end()));
    }
}
