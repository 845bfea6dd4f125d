#include "physics/world/hull.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <doctest/doctest.h>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using physics::collision_hull;
using physics::CollisionHull;

namespace {

std::vector<glm::dvec3> vertices_of(const test::Polyhedron& polyhedron) {
    std::vector<glm::dvec3> points;
    for (const test::Polygon& face : polyhedron) points.insert(points.end(), face.begin(), face.end());
    return points;
}

std::vector<glm::dvec3> sphere_points(int count, double radius) {
    std::vector<glm::dvec3> points;
    for (int i = 0; i < count; ++i) {
        const double y = 1.0 - 2.0 * (i + 0.5) / count, angle = i * 2.399963229728653, r = std::sqrt(1.0 - y * y);
        points.push_back(glm::dvec3(r * std::cos(angle), y, r * std::sin(angle)) * radius);
    }
    return points;
}

double support(std::span<const glm::dvec3> points, const glm::dvec3& direction) {
    double most = -std::numeric_limits<double>::infinity();
    for (const glm::dvec3& point : points) most = std::max(most, glm::dot(point, direction));
    return most;
}

// Returns how far hull + margin reaches outside the points' hull over many directions, m; negative inside. The support
// function decides containment of convex sets.
double overreach(const CollisionHull& hull, const std::vector<glm::dvec3>& points, const glm::dvec3& origin) {
    double most = -std::numeric_limits<double>::infinity();
    test::Random random(77);
    const std::vector<glm::dvec3> own(hull.points.begin(), hull.points.end());
    for (int i = 0; i < 3000; ++i) {
        const glm::dvec3 direction = random.direction();
        const double outer = support(points, direction) - glm::dot(origin, direction);
        most = std::max(most, support(own, direction) + hull.margin - outer);
    }
    return most;
}

void check_usable(const CollisionHull& hull, size_t max_vertices) {
    CHECK(hull.points.size() >= 4);
    CHECK(hull.points.size() <= max_vertices);
    CHECK(hull.margin > 0.0f);
    for (const glm::vec3& point : hull.points)
        CHECK((std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z)));
    double volume = 0.0; // of the largest tetrahedron at the first point; positive: not coplanar
    for (size_t i = 1; i < hull.points.size(); ++i)
        for (size_t j = 1; j < i; ++j)
            for (size_t k = 1; k < j; ++k) {
                const glm::dvec3 a = glm::dvec3(hull.points[i]) - glm::dvec3(hull.points[0]);
                const glm::dvec3 b = glm::dvec3(hull.points[j]) - glm::dvec3(hull.points[0]);
                const glm::dvec3 c = glm::dvec3(hull.points[k]) - glm::dvec3(hull.points[0]);
                volume = std::max(volume, std::abs(glm::dot(a, glm::cross(b, c))));
            }
    CHECK(volume > 0.0);
}

// Returns how far the points reach outside hull + margin at most, over many directions, m.
double deviation(const CollisionHull& hull, const std::vector<glm::dvec3>& points, const glm::dvec3& origin) {
    const std::vector<glm::dvec3> own(hull.points.begin(), hull.points.end());
    test::Random random(11);
    double most = 0.0;
    for (int i = 0; i < 1000; ++i) {
        const glm::dvec3 direction = random.direction();
        most = std::max(most, support(points, direction) - glm::dot(origin, direction) - support(own, direction)
                                  - static_cast<double>(hull.margin));
    }
    return most;
}

} // namespace

TEST_CASE("no points, one point, a line and a triangle still give a hull") {
    const std::vector<std::vector<glm::dvec3>> sets{
        {},
        {{0.1, 0.2, 0.3}},
        {{0.1, 0.2, 0.3}, {0.1, 0.2, 0.3}, {0.1, 0.2, 0.3}, {0.1, 0.2, 0.3}},
        {{0, 0, 0}, {0.1, 0.1, 0}},
        {{0, 0, 0}, {0.1, 0.1, 0.1}, {0.2, 0.2, 0.2}, {0.3, 0.3, 0.3}, {0.5, 0.5, 0.5}},
        {{0, 0, 0}, {0.1, 0, 0.05}, {0, 0.1, 0.02}},
        {{0, 0, 0}, {0.1, 0, 0.1}, {0.1, 0.1, 0.1}, {0, 0.1, 0}, {0.05, 0.05, 0.05}},
    };
    for (const auto& points : sets) {
        CAPTURE(points.size());
        const CollisionHull hull = collision_hull(points, {0.05, 0.0, 0.0});
        check_usable(hull, 32);
        if (points.empty()) continue;
        glm::dvec3 low = points[0], high = points[0];
        for (const glm::dvec3& p : points) low = glm::min(low, p), high = glm::max(high, p);
        const double extent = glm::length(high - low);
        CHECK(overreach(hull, points, {0.05, 0.0, 0.0}) <= std::max(1e-4 * extent, 1.8e-4));
    }
}

TEST_CASE("points that are not finite are ignored") {
    std::vector<glm::dvec3> points = vertices_of(test::box_polyhedron(glm::dvec3(-0.1), glm::dvec3(0.1)));
    const CollisionHull clean = collision_hull(points, glm::dvec3(0.0));
    points.push_back({std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0});
    points.push_back({0.0, std::numeric_limits<double>::infinity(), 0.0});
    const CollisionHull hull = collision_hull(points, glm::dvec3(0.0));
    CHECK(hull.points == clean.points);
}

TEST_CASE("a box keeps its eight corners, each moved in by the margin") {
    const std::vector<glm::dvec3> points = vertices_of(test::box_polyhedron({-0.1, -0.2, -0.3}, {0.1, 0.2, 0.3}));
    const CollisionHull hull = collision_hull(points, glm::dvec3(0.0));
    CHECK(hull.points.size() == 8);
    CHECK(hull.margin == doctest::Approx(0.004).epsilon(0.05).scale(0.0)); // a fiftieth of the thinnest extent
    for (const glm::vec3& corner : hull.points) {
        CHECK(std::abs(corner.x) == doctest::Approx(0.096).epsilon(1e-3).scale(0.0));
        CHECK(std::abs(corner.y) == doctest::Approx(0.196).epsilon(1e-3).scale(0.0));
        CHECK(std::abs(corner.z) == doctest::Approx(0.296).epsilon(1e-3).scale(0.0));
    }
}

TEST_CASE("the margin is bounded by its setting and by the size of the piece") {
    const auto margin_of = [](double half, physics::HullSettings settings) {
        const auto points = vertices_of(test::box_polyhedron(glm::dvec3(-half), glm::dvec3(half)));
        return collision_hull(points, glm::dvec3(0.0), settings).margin;
    };
    CHECK(margin_of(5.0, {}) == doctest::Approx(0.01).epsilon(0.05).scale(0.0));
    CHECK(margin_of(5.0, {.max_margin = 0.002f}) == doctest::Approx(0.002).epsilon(0.05).scale(0.0));
    CHECK(margin_of(0.01, {}) == doctest::Approx(0.0004).epsilon(0.05).scale(0.0));
    CHECK(margin_of(0.01, {.margin_fraction = 0.05f}) == doctest::Approx(0.001).epsilon(0.05).scale(0.0));
}

TEST_CASE("margins that are zero or leave no core are clamped") {
    const auto points = vertices_of(test::box_polyhedron(glm::dvec3(-0.1), glm::dvec3(0.1)));
    for (const float fraction : {-1.0f, 0.0f, 0.5f, 100.0f}) {
        for (const float bound : {-1.0f, 0.0f, 1.0f}) {
            const CollisionHull hull = collision_hull(
                points, glm::dvec3(0.0), {.max_vertices = 0, .margin_fraction = fraction, .max_margin = bound});
            check_usable(hull, 8);
            CHECK(overreach(hull, points, glm::dvec3(0.0)) <= 1e-6);
        }
    }
}

TEST_CASE("a cube has twelve edges, whatever the order of its points and the triangulation of its faces") {
    std::vector<glm::vec3> points;
    for (const glm::dvec3& point : vertices_of(test::box_polyhedron(glm::dvec3(-0.1), glm::dvec3(0.1))))
        points.push_back(glm::vec3(point)); // each corner three times
    const std::vector<physics::HullEdge> edges = physics::hull_edges(points);
    CHECK(edges.size() == 12);
    for (const auto& [from, to] : edges) {
        CHECK(from < to);
        CHECK(glm::length(points[from] - points[to]) == doctest::Approx(0.2).epsilon(1e-5).scale(0.0));
    }
    CHECK(physics::hull_edges({}).empty());
    CHECK(physics::hull_edges(std::vector<glm::vec3>(5, glm::vec3(1.0f))).empty());
}

TEST_CASE("hull and margin stay inside the points, for any shape, size and place") {
    for (const double size : {1e-4, 0.1, 10.0, 1e4}) {
        for (const glm::dvec3& place : {glm::dvec3(0.0), glm::dvec3(100.0, -50.0, 3.0)}) {
            for (uint64_t seed = 0; seed < 4; ++seed) {
                const auto fragments = test::wedge_pieces(place, place + glm::dvec3(1.0, 0.5, 0.7) * size, 5, seed);
                for (const fracture::Piece& piece : fragments.pieces) {
                    const auto span = fragments.positions_of(piece);
                    const std::vector<glm::dvec3> points(span.begin(), span.end());
                    const CollisionHull hull = collision_hull(points, piece.mass.centre_of_mass);
                    check_usable(hull, 32);
                    CAPTURE(size);
                    CAPTURE(seed);
                    CHECK(overreach(hull, points, piece.mass.centre_of_mass) <= 1e-4 * size);
                }
            }
        }
    }
}

TEST_CASE("thin plates and needles of every ratio stay inside their points") {
    for (const double ratio : {1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9}) {
        for (const glm::dvec3& half : {glm::dvec3(0.1, 0.1, 0.1 * ratio), glm::dvec3(0.1, 0.1 * ratio, 0.1 * ratio)}) {
            const auto points = vertices_of(test::box_polyhedron(-half, half));
            CAPTURE(ratio);
            const CollisionHull hull = collision_hull(points, glm::dvec3(0.0));
            check_usable(hull, 32);
            CHECK(overreach(hull, points, glm::dvec3(0.0)) <= 2e-5);
        }
    }
}

TEST_CASE("a sphere of two thousand points is reduced and loses little of its width") {
    const std::vector<glm::dvec3> points = sphere_points(2000, 0.5);
    for (const uint32_t bound : {8u, 16u, 32u, 64u}) {
        const CollisionHull hull = collision_hull(points, glm::dvec3(0.0), {.max_vertices = bound});
        check_usable(hull, bound);
        CHECK(hull.points.size() == bound);
        CHECK(overreach(hull, points, glm::dvec3(0.0)) <= 0.0);
        if (bound < 32) continue;
        const std::vector<glm::dvec3> own(hull.points.begin(), hull.points.end());
        test::Random random(3);
        double width = 1.0;
        for (int i = 0; i < 500; ++i) {
            const glm::dvec3 direction = random.direction();
            width = std::min(width, support(own, direction) + support(own, -direction) + 2.0 * hull.margin);
        }
        CHECK(width > 0.85);
    }
}

TEST_CASE("no corner of a piece reaches far outside its hull, below a floor on which the hull stands") {
    // At best, 32 points cover a sphere within 23 degrees, a depth of 0.08 radii. The greedy choice was observed to
    // reach 30 degrees and 0.13 radii, which set the bound.
    const std::vector<glm::dvec3> ball = sphere_points(2000, 0.5);
    CHECK(deviation(collision_hull(ball, glm::dvec3(0.0)), ball, glm::dvec3(0.0)) < 0.16 * 0.5);
    std::vector<double> shares;
    for (const char* name : {"cube", "animal", "arch", "wall", "icosphere"})
        for (const uint64_t seed : {1, 2}) {
            const fracture::TriangleMesh mesh = *fracture::shape(name);
            const auto fragments = fracture::fracture(mesh, fracture::uniform_sites(fracture::bounds(mesh), 100, seed));
            REQUIRE(fragments);
            for (const fracture::Piece& piece : fragments->pieces) {
                const auto span = fragments->positions_of(piece);
                const std::vector<glm::dvec3> points(span.begin(), span.end());
                const glm::dvec3 size = fracture::bounds(points).size();
                const CollisionHull hull = collision_hull(points, piece.mass.centre_of_mass);
                shares.push_back(deviation(hull, points, piece.mass.centre_of_mass) / glm::length(size));
            }
        }
    std::ranges::sort(shares);
    MESSAGE(shares.size(), " pieces: half below ", shares[shares.size() / 2],
            " of their diagonal, all but a twentieth below ", shares[shares.size() * 19 / 20], ", the worst ",
            shares.back());
    // Observed: 0.006, 0.011 and 0.03. Farthest-point sampling, the rejected alternative, gave 0.02, 0.04 and 0.07.
    CHECK(shares[shares.size() / 2] < 0.01);
    CHECK(shares[shares.size() * 19 / 20] < 0.02);
    CHECK(shares.back() < 0.05);
}

TEST_CASE("parallel hulls equal sequential ones for any number of threads") {
    const auto fragments = test::voronoi_pieces(glm::dvec3(-0.5), glm::dvec3(0.5), 60, 21);
    for (const uint32_t threads : {1u, 2u, 5u}) {
        const physics::PieceHulls hulls = physics::collision_hulls(fragments, {}, threads);
        REQUIRE(hulls.size() == fragments.pieces.size());
        for (size_t i = 0; i < hulls.size(); ++i) {
            const fracture::Piece& piece = fragments.pieces[i];
            const CollisionHull alone = collision_hull(fragments.positions_of(piece), piece.mass.centre_of_mass);
            CHECK(hulls[i]->points == alone.points);
            CHECK(hulls[i]->margin == alone.margin);
        }
    }
    CHECK(physics::collision_hulls({}).empty());
}

TEST_CASE("the hull of many points keeps the corners, and crumbs get few vertices") {
    // A long box with a thousand points inside and on its faces keeps all eight corners, wherever they are in the list.
    test::Random random(4);
    std::vector<glm::dvec3> points;
    const glm::dvec3 half(1.0, 0.2, 0.05);
    for (int i = 0; i < 1000; ++i) points.push_back(random.point(-half, half));
    for (int corner = 0; corner < 8; ++corner)
        points.push_back(half * glm::dvec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1));
    CHECK(overreach(collision_hull(points, glm::dvec3(0.0)), points, glm::dvec3(0.0)) < 1e-6);
    const CollisionHull hull = collision_hull(points, glm::dvec3(0.0));
    CHECK(hull.points.size() == 8);
    for (const glm::vec3& point : hull.points)
        for (int axis = 0; axis < 3; ++axis)
            CHECK(std::abs(std::abs(point[axis]) - (half[axis] - static_cast<double>(hull.margin))) < 1e-4);

    const std::vector<glm::dvec3> ball = sphere_points(2000, 0.014);
    CHECK(collision_hull(ball, glm::dvec3(0.0)).points.size() <= 12);
    CHECK(collision_hull(ball, glm::dvec3(0.0), {.crumb_vertices = 9}).points.size() <= 9);
    CHECK(collision_hull(sphere_points(2000, 0.016), glm::dvec3(0.0)).points.size() > 12);
    check_usable(collision_hull(ball, glm::dvec3(0.0)), 12);
}
