#include "fracture/doctor/repair.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "fracture/base/random.h"
#include "fracture/mesh/intersections.h"
#include "fracture/mesh/topology.h"
#include "fracture/shapes/shapes.h"
#include "fracture/triangulation/triangulate.h"
#include "tests/fracture/mesh_checks.h"
#include "tests/fracture/repair_checks.h"

using namespace brittle::fracture;
using namespace brittle::fracture::test;

namespace {

// A prism without lids over a polygon in the XZ plane, counter-clockwise as seen from above, y from 0 to 1.
TriangleMesh open_prism(const std::vector<glm::dvec2>& polygon) {
    TriangleMesh mesh;
    const auto n = static_cast<uint32_t>(polygon.size());
    for (const double y : {0.0, 1.0})
        for (const glm::dvec2& p : polygon) mesh.positions.emplace_back(p.x, y, -p.y);
    for (uint32_t k = 0; k < n; ++k) {
        const uint32_t next = (k + 1) % n;
        mesh.triangles.emplace_back(k, next, n + next);
        mesh.triangles.emplace_back(k, n + next, n + k);
    }
    return mesh;
}

double area_of(const std::vector<glm::dvec2>& polygon) {
    double twice = 0.0;
    for (size_t k = 0; k < polygon.size(); ++k) {
        const glm::dvec2 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
        twice += a.x * b.y - a.y * b.x;
    }
    return twice / 2.0;
}

// A strip along a trefoil knot, closed to a band. Both rims are knots of n edges, and every projection of a knot
// crosses itself.
TriangleMesh knotted_band(uint32_t n) {
    TriangleMesh band;
    for (uint32_t k = 0; k < n; ++k) {
        const double a = 2.0 * std::numbers::pi * k / n;
        const glm::dvec3 p(std::sin(a) + 2.0 * std::sin(2.0 * a), std::cos(a) - 2.0 * std::cos(2.0 * a),
                           -std::sin(3.0 * a));
        band.positions.push_back(p);
        band.positions.push_back(p * 1.1);
    }
    for (uint32_t k = 0; k < n; ++k) {
        const uint32_t a = 2 * k, b = 2 * ((k + 1) % n);
        band.triangles.emplace_back(a, b, b + 1);
        band.triangles.emplace_back(a, b + 1, a + 1);
    }
    return band;
}

} // namespace

TEST_CASE("a cube with missing faces is closed") {
    const TriangleMesh cube = plain_cube();
    for (uint32_t t = 0; t < 12; ++t) {
        const TriangleMesh open = without(cube, {t});
        const Repaired repaired = check_solid(open, 8.0);
        CHECK(repaired.report.closed_holes.count == 1);
        CHECK(repaired.report.new_triangles == 1);
        CHECK(std::equal(open.triangles.begin(), open.triangles.end(), repaired.mesh.triangles.begin()));
        CHECK(repaired.source_triangle.back() == no_index);
        CHECK(repaired.source_triangle.front() == 0);
    }
    for (uint32_t t = 0; t < 12; t += 2) check_solid(without(cube, {t, t + 1}), 8.0); // a side
    for (uint32_t a = 0; a < 12; ++a)
        for (uint32_t b = 0; b < a; ++b) {
            const TriangleMesh open = without(cube, {a, b});
            const Repaired repaired = repair(open);
            check_promises(open, repaired);
            CHECK(is_manifold(repaired.mesh));
        }
    // Five of twelve triangles: two sides and half of a third.
    const TriangleMesh open = without(cube, {0, 1, 4, 5, 8});
    const Repaired repaired = repair(open);
    check_promises(open, repaired);
    CHECK(is_manifold(repaired.mesh));
    CHECK(std::equal(open.triangles.begin(), open.triangles.end(), repaired.mesh.triangles.begin()));
    CHECK(test::signed_volume(repaired.mesh) > 0.0);
}

TEST_CASE("a sphere with random triangles missing") {
    for (uint64_t seed = 0; seed < 40; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const TriangleMesh sphere = icosphere(3);
        TriangleMesh open = sphere;
        const double part = 0.3 * random.uniform();
        std::erase_if(open.triangles, [&](const Triangle&) { return random.uniform() < part; });
        const Repaired repaired = repair(open);
        check_promises(open, repaired);
        INFO(describe(repaired.report));
        CHECK(is_manifold(repaired.mesh));
        check_sources(open, repaired);
        CHECK(test::signed_volume(repaired.mesh) == doctest::Approx(test::signed_volume(sphere)).epsilon(0.05));
    }
}

TEST_CASE("bow-ties: holes that meet in a vertex") {
    const TriangleMesh whole = icosphere(2);
    // The triangles around a vertex, with every second one missing.
    for (uint32_t v = 0; v < 12; ++v) {
        std::vector<uint32_t> fan;
        for (uint32_t t = 0; t < whole.triangles.size(); ++t)
            if (whole.triangles[t].x == v || whole.triangles[t].y == v || whole.triangles[t].z == v) fan.push_back(t);
        REQUIRE(fan.size() == 5);
        for (uint32_t mask = 1; mask < 31; ++mask) {
            std::vector<uint32_t> missing;
            for (uint32_t k = 0; k < 5; ++k)
                if (mask >> k & 1) missing.push_back(fan[k]);
            const TriangleMesh open = without(whole, missing);
            const Repaired repaired = check_solid(open, test::signed_volume(whole), 0.02);
            CHECK(repaired.mesh.positions.size() == whole.positions.size());
        }
    }
}

TEST_CASE("an open hemisphere gets a disc") {
    const TriangleMesh sphere = icosphere(4);
    TriangleMesh half = sphere;
    std::erase_if(half.triangles, [&](const Triangle& t) {
        return std::min({sphere.positions[t.x].y, sphere.positions[t.y].y, sphere.positions[t.z].y}) < -1e-9;
    });
    const Repaired repaired = repair(half);
    check_promises(half, repaired);
    CHECK(is_manifold(repaired.mesh));
    CHECK(repaired.report.closed_holes.count == 1);
    CHECK(test::signed_volume(repaired.mesh) == doctest::Approx(2.0 / 3.0 * std::numbers::pi).epsilon(0.08));
}

TEST_CASE("a cylinder without lids, and prisms over polygons that are not convex") {
    std::vector<glm::dvec2> circle;
    for (int k = 0; k < 5000; ++k)
        circle.emplace_back(std::cos(k * std::numbers::pi / 2500), std::sin(k * std::numbers::pi / 2500));
    check_solid(open_prism(circle), area_of(circle), 1e-9);
    const std::vector<glm::dvec2> l_shape = {{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 2}, {0, 2}};
    check_solid(open_prism(l_shape), 4.0);
    std::vector<glm::dvec2> star;
    for (int k = 0; k < 40; ++k) {
        const double r = k % 2 == 0 ? 1.0 : 0.2, angle = k * std::numbers::pi / 20;
        star.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
    check_solid(open_prism(star), area_of(star), 1e-9);
    const std::vector<glm::dvec2> u_shape = {{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
    CHECK(check_solid(open_prism(u_shape), 7.0).report.closed_holes.count == 2);
}

TEST_CASE("the ends of a pipe are rings") {
    std::vector<glm::dvec2> outer, inner;
    for (int k = 0; k < 60; ++k) {
        const double angle = k * std::numbers::pi / 30;
        outer.emplace_back(std::cos(angle), std::sin(angle));
        if (k % 2 == 0) inner.emplace_back(0.5 * std::cos(angle) + 0.2, 0.5 * std::sin(angle));
    }
    TriangleMesh pipe = open_prism(outer), bore = open_prism(inner);
    for (Triangle& t : bore.triangles) turn(t);
    append(pipe, bore);
    Repaired repaired = check_solid(pipe, area_of(outer) - area_of(inner), 1e-9);
    CHECK(check_topology(repaired.mesh.positions.size(), repaired.mesh.triangles).components == 1);
    CHECK(repaired.report.closed_holes.count == 4);
    CHECK(repaired.report.new_triangles == 2 * 90);
    // The pipe in a plane that is normal to no axis, inside out, and with a rod in the bore.
    append(pipe, open_prism({{0.1, -0.1}, {0.3, -0.1}, {0.3, 0.1}, {0.1, 0.1}}));
    for (Triangle& t : pipe.triangles) turn(t);
    const glm::dvec3 x = glm::normalize(glm::dvec3(1, 2, 3)), y = glm::normalize(glm::cross(x, glm::dvec3(1, 0, 0)));
    for (glm::dvec3& p : pipe.positions) p = x * p.x + y * p.y + glm::cross(x, y) * p.z;
    repaired = check_solid(pipe, area_of(outer) - area_of(inner) + 0.04, 1e-9);
    CHECK(check_topology(repaired.mesh.positions.size(), repaired.mesh.triangles).components == 2);
    CHECK(repaired.report.turned_triangles.count == pipe.triangles.size());
}

TEST_CASE("only rims up to the given length are closed") {
    const TriangleMesh open = without(plain_cube(), {0, 1, 4});
    RepairSettings settings;
    settings.close_holes = 7.5;
    const Repaired some = repair(open, settings);
    check_promises(open, some, settings);
    CHECK(some.report.closed_holes.count + some.report.open_rims.count >= 1);
    settings.close_holes = 0.0;
    const Repaired none = repair(open, settings);
    CHECK(same(none.mesh, open));
    CHECK(none.report.open_rims.count >= 1);
    CHECK(describe(none.report).find("left open") != std::string::npos);
}

TEST_CASE("a rim that is not simple in any projection is closed") {
    for (const uint32_t n : {60u, 120u, 300u, 1000u}) {
        CAPTURE(n);
        const TriangleMesh band = knotted_band(n);
        const Repaired repaired = repair(band);
        check_promises(band, repaired);
        CHECK(is_manifold(repaired.mesh));
        CHECK(repaired.report.closed_holes.count == 2);
    }
}

TEST_CASE("a long rim stays open where it is not simple, and is closed where it is") {
    const TriangleMesh band = knotted_band(5000);
    const Repaired repaired = repair(band);
    CHECK(same(repaired.mesh, band));
    CHECK(repaired.report.long_rims.count == 2);
}

TEST_CASE("a one-sided surface is cut and closed") {
    TriangleMesh moebius;
    const uint32_t n = 20;
    for (uint32_t k = 0; k < n; ++k) {
        const double a = 2.0 * std::numbers::pi * k / n;
        for (const double w : {-0.3, 0.3})
            moebius.positions.emplace_back((1 + w * std::cos(a / 2)) * std::cos(a), w * std::sin(a / 2),
                                           (1 + w * std::cos(a / 2)) * std::sin(a));
    }
    for (uint32_t k = 0; k < n; ++k) {
        const uint32_t a = 2 * k, b = k + 1 == n ? 1 : 2 * k + 2, c = k + 1 == n ? 0 : 2 * k + 3;
        moebius.triangles.emplace_back(a, b, c);
        moebius.triangles.emplace_back(a, c, a + 1);
    }
    const Repaired repaired = repair(moebius);
    check_promises(moebius, repaired);
    CHECK(is_manifold(repaired.mesh));
    CHECK(repaired.report.cut_edges.count > 0);
}

namespace {

// A ball without the cap above a height.
TriangleMesh open_ball(double height) {
    const TriangleMesh ball = icosphere(4);
    TriangleMesh open{ball.positions, {}};
    for (const Triangle& t : ball.triangles)
        if (ball.positions[t.x].y + ball.positions[t.y].y + ball.positions[t.z].y < 3.0 * height)
            open.triangles.push_back(t);
    return open;
}

// Hills over a square, whose rim goes up and down with them.
TriangleMesh terrain(uint32_t n) {
    TriangleMesh mesh;
    for (uint32_t j = 0; j <= n; ++j)
        for (uint32_t i = 0; i <= n; ++i) {
            const double u = static_cast<double>(i) / n, v = static_cast<double>(j) / n;
            const double y = 0.2 * std::sin(9.0 * u) * std::cos(7.0 * v) + 0.1 * std::sin(23.0 * u + 3.0 * v);
            mesh.positions.emplace_back(u, y, v);
        }
    for (uint32_t j = 0; j < n; ++j)
        for (uint32_t i = 0; i < n; ++i) {
            const uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
            mesh.triangles.emplace_back(a, d, b);
            mesh.triangles.emplace_back(a, c, d);
        }
    return mesh;
}

RepairSettings with(RepairSettings::Remesh remesh) {
    RepairSettings settings;
    settings.remesh_holes = remesh;
    return settings;
}

// The furthest that new vertices are from the unit sphere.
double furthest_from_sphere(const TriangleMesh& open, const Repaired& repaired) {
    double furthest = 0.0;
    for (size_t v = open.positions.size(); v < repaired.mesh.positions.size(); ++v)
        furthest = std::max(furthest, std::abs(glm::length(repaired.mesh.positions[v]) - 1.0));
    return furthest;
}

} // namespace

TEST_CASE("a hole in a ball is closed flat, or so that the curvature goes on") {
    const TriangleMesh open = open_ball(0.8);
    const auto closed = [&](RepairSettings::Remesh remesh) {
        const Repaired repaired = repair(open, with(remesh));
        CHECK(check_topology(repaired.mesh.positions.size(), repaired.mesh.triangles).manifold());
        CHECK(repaired.report.crossing_fills.count == 0);
        CHECK(repair(repaired.mesh).mesh.triangles == repaired.mesh.triangles);
        return repaired;
    };
    const Repaired plain = closed(RepairSettings::Remesh::none), flat = closed(RepairSettings::Remesh::flat),
                   smooth = closed(RepairSettings::Remesh::smooth);
    CHECK(plain.mesh.positions.size() == open.positions.size());
    CHECK(flat.report.new_vertices.count > 50);
    CHECK(flat.mesh.triangles == smooth.mesh.triangles); // only the places of the vertices differ
    CHECK(furthest_from_sphere(open, flat) > 0.15);
    CHECK(furthest_from_sphere(open, smooth) < furthest_from_sphere(open, flat) / 3.0);
    // As dense as around: the longest edge of the fill is not twice the longest of the ball.
    const auto longest = [](const TriangleMesh& mesh, size_t first) {
        double length = 0.0;
        for (size_t t = first; t < mesh.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k)
                length = std::max(length, glm::distance(mesh.positions[mesh.triangles[t][k]],
                                                        mesh.positions[mesh.triangles[t][(k + 1) % 3]]));
        return length;
    };
    CHECK(longest(smooth.mesh, open.triangles.size()) < 2.0 * longest(open, 0));
}

TEST_CASE("of the fills of a hilly rim the one that crosses the surface least is taken, and the rest is told") {
    constexpr uint32_t n = 24;
    const TriangleMesh open = terrain(n);
    // The fill in projection keeps the rim's heights and passes through every hill.
    TriangleMesh in_projection = open;
    std::vector<glm::dvec2> places;
    for (const glm::dvec3& p : open.positions) places.emplace_back(p.x, p.z);
    Loop rim;
    for (uint32_t k = 0; k < n; ++k) rim.push_back(k);
    for (uint32_t k = 0; k < n; ++k) rim.push_back(k * (n + 1) + n);
    for (uint32_t k = n; k > 0; --k) rim.push_back(n * (n + 1) + k);
    for (uint32_t k = n; k > 0; --k) rim.push_back(k * (n + 1));
    const Triangulation fill = triangulate(places, std::span(&rim, 1));
    in_projection.triangles.insert(in_projection.triangles.end(), fill.triangles.begin(), fill.triangles.end());
    const uint64_t crossings = find_intersections(in_projection, 100'000'000).pairs;
    REQUIRE(crossings > 0);
    for (const auto remesh :
         {RepairSettings::Remesh::none, RepairSettings::Remesh::flat, RepairSettings::Remesh::smooth}) {
        const Repaired repaired = repair(open, with(remesh));
        CHECK(check_topology(repaired.mesh.positions.size(), repaired.mesh.triangles).manifold());
        const uint64_t found = find_intersections(repaired.mesh, 100'000'000).pairs;
        CHECK(repaired.report.crossing_fills.count == (found > 0 ? 1 : 0));
        CHECK(repaired.report.fill_crossings == found);
        CHECK(found < crossings);
        CHECK((found == 0 || describe(repaired.report).find("closed across the surface") != std::string::npos));
    }
}
