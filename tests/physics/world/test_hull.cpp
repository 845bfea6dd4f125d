#include "physics/world/hull.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "fracture/fracture.h"
#include "fracture/mesh/convex_hull.h"
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

TEST_CASE("a hull that is cut stays behind the plane with its margin, and keeps its other corners bit for bit") {
    const std::vector<glm::dvec3> ball = sphere_points(2000, 1.0);
    CollisionHull hull = collision_hull(ball, glm::dvec3(0.0));
    test::Random random(5);
    for (int round = 0; round < 40; ++round) { // each a little deeper than the one before, from all sides
        const glm::dvec3 normal = random.direction();
        const double distance = 0.9 - 0.005 * round;
        const std::optional<CollisionHull> cut = physics::cut_hull(hull, {normal, distance});
        REQUIRE(cut.has_value());
        CHECK(cut->margin == hull.margin);
        CHECK(cut->points.size() <= 32);
        CHECK(cut->points.size() >= 8);
        CHECK(cut->faces.count() >= 4);
        CHECK(cut->section.mean() > 0.0f);
        size_t behind = 0, kept = 0;
        for (const glm::vec3& p : hull.points)
            if (glm::dot(normal, glm::dvec3(p)) < distance - static_cast<double>(hull.margin)) {
                ++behind;
                kept += std::ranges::find(cut->points, p) != cut->points.end() ? 1 : 0;
            }
        CHECK(kept >= std::min<size_t>(behind, 32) / 2);
        for (const glm::vec3& p : cut->points) {
            CHECK(glm::dot(normal, glm::dvec3(p)) + static_cast<double>(cut->margin) <= distance + 1e-6);
            CHECK(glm::length(p) < 1.0f);
        }
        hull = *cut;
    }
    const fracture::TriangleMesh full = fracture::convex_hull(hull.points);
    // The part of the ball behind forty planes at 0.9 to 0.7 of its radius holds the ball of 0.7.
    CHECK(fracture::signed_volume(full.positions, full.triangles) > 0.85 * 4.18879 * 0.7 * 0.7 * 0.7);
    // Of a cube, all of whose corners fit in, half remains.
    const CollisionHull cube = collision_hull(fracture::cube(1.0).positions, glm::dvec3(0.0));
    const std::optional<CollisionHull> half = physics::cut_hull(cube, {{0, 1, 0}, 0.1});
    REQUIRE(half.has_value());
    CHECK(half->points.size() == 8);
    for (const glm::vec3& p : cube.points)
        if (p.y < 0.0f) CHECK(std::ranges::find(half->points, p) != half->points.end());
    CHECK_FALSE(physics::cut_hull(cube, {{0, 1, 0}, -5.0}).has_value());
    CHECK_FALSE(physics::cut_hull({}, {{0, 1, 0}, 0.0}).has_value());
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

TEST_CASE("hulls of rough pieces do not pass the mean plane of a contact, and those of flat pieces stay as they are") {
    const fracture::TriangleMesh cube = fracture::cuboid({1.0, 1.0, 1.0});
    const auto sites = fracture::uniform_sites(fracture::bounds(cube), 30, 4);
    fracture::Settings settings;
    for (const double amount : {0.0, 1.0}) {
        settings.rough.amount = amount;
        const auto fragments = fracture::fracture(cube, sites, settings);
        REQUIRE(fragments);
        const physics::PieceHulls hulls = physics::collision_hulls(*fragments);
        double deepest = 0.0; // of the points alone, beyond the plane
        for (const fracture::Bond& bond : fragments->bonds) {
            for (const uint32_t p : {bond.a, bond.b}) {
                const glm::dvec3 outwards = p == bond.a ? bond.normal : -bond.normal;
                const fracture::Piece& piece = fragments->pieces[p];
                const double plane = glm::dot(outwards, bond.centroid - piece.mass.centre_of_mass);
                const std::vector<glm::dvec3> points(hulls[p]->points.begin(), hulls[p]->points.end());
                CHECK(support(points, outwards) < plane + 1e-6);
                const auto own = fragments->positions_of(piece);
                deepest = std::max(deepest, support(own, outwards) - glm::dot(outwards, bond.centroid));
            }
        }
        CHECK((amount > 0.0 ? deepest > 0.02 : deepest < 1e-12));
        for (size_t i = 0; i < hulls.size() && amount == 0.0; ++i) {
            const fracture::Piece& piece = fragments->pieces[i];
            CHECK(hulls[i]->points == collision_hull(fragments->positions_of(piece), piece.mass.centre_of_mass).points);
        }
    }
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

namespace {

using physics::hull_faces;
using physics::HullFaces;

std::vector<glm::vec3> box_corners(const glm::vec3& half) {
    std::vector<glm::vec3> corners;
    for (int i = 0; i < 8; ++i) corners.push_back(half * glm::vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
    return corners;
}

// Twice the area of a face.
glm::dvec3 area_of(const std::vector<glm::vec3>& points, std::span<const uint16_t> loop) {
    glm::dvec3 area(0.0);
    const glm::dvec3 apex(points[loop[0]]);
    for (size_t i = 2; i < loop.size(); ++i)
        area += glm::cross(glm::dvec3(points[loop[i - 1]]) - apex, glm::dvec3(points[loop[i]]) - apex);
    return area;
}

double extent_of(const std::vector<glm::vec3>& points) {
    glm::vec3 low = points[0], high = low;
    for (const glm::vec3& p : points) low = glm::min(low, p), high = glm::max(high, p);
    return static_cast<double>(std::max({high.x - low.x, high.y - low.y, high.z - low.z}));
}

// Every face is a convex loop, counter-clockwise seen from outside, and no point is in front of it by more than
// `tolerance`, a part of the extent. Returns the sum of the areas.
double check_faces(const std::vector<glm::vec3>& points, const HullFaces& faces, double tolerance) {
    glm::dvec3 middle(0.0);
    for (const glm::vec3& p : points) middle += glm::dvec3(p) / static_cast<double>(points.size());
    const double extent = extent_of(points);
    double sum = 0.0;
    for (size_t face = 0; face < faces.count(); ++face) {
        CAPTURE(face);
        const std::span<const uint16_t> loop = faces.of(face);
        REQUIRE(loop.size() >= 3);
        const auto at = [&](size_t i) { return glm::dvec3(points[loop[i % loop.size()]]); };
        const glm::dvec3 area = area_of(points, loop), normal = glm::normalize(area);
        sum += 0.5 * glm::length(area);
        CHECK(glm::dot(normal, at(0) - middle) > 0.0);
        for (size_t i = 0; i < loop.size(); ++i) {
            CHECK(std::ranges::count(loop, loop[i]) == 1);
            CHECK(glm::dot(glm::cross(at(i + 1) - at(i), at(i + 2) - at(i + 1)), normal) > 0.0);
        }
        double in_front = 0.0;
        for (const glm::vec3& p : points) in_front = std::max(in_front, glm::dot(normal, glm::dvec3(p) - at(0)));
        CHECK(in_front <= tolerance * extent);
    }
    return sum;
}

double area_of_mesh(const fracture::TriangleMesh& mesh) {
    double area = 0.0;
    for (const auto& triangle : mesh.triangles)
        area += 0.5
                * glm::length(glm::cross(mesh.positions[triangle[1]] - mesh.positions[triangle[0]],
                                         mesh.positions[triangle[2]] - mesh.positions[triangle[0]]));
    return area;
}

// Each side of a face with its direction, sorted.
std::vector<std::pair<uint16_t, uint16_t>> sides_of(const HullFaces& faces) {
    std::vector<std::pair<uint16_t, uint16_t>> sides;
    for (size_t face = 0; face < faces.count(); ++face) {
        const std::span<const uint16_t> loop = faces.of(face);
        for (size_t i = 0; i < loop.size(); ++i) sides.emplace_back(loop[i], loop[(i + 1) % loop.size()]);
    }
    std::ranges::sort(sides);
    return sides;
}

// Two faces meet at each side, in opposite directions; and V - E + F = 2.
void check_closed(const HullFaces& faces) {
    const auto sides = sides_of(faces);
    CHECK(std::ranges::adjacent_find(sides) == sides.end());
    for (const auto& [from, to] : sides) CHECK(std::ranges::binary_search(sides, std::pair(to, from)));
    std::vector<uint16_t> used = faces.corners;
    std::ranges::sort(used);
    const auto vertices = static_cast<size_t>(std::unique(used.begin(), used.end()) - used.begin());
    CHECK(vertices + faces.count() == sides.size() / 2 + 2);
}

} // namespace

TEST_CASE("hull faces: too few points, points on a line or in a plane, and too many points give none") {
    CHECK(hull_faces({}).count() == 0);
    CHECK(hull_faces(std::vector<glm::vec3>(3, glm::vec3(1.0f))).count() == 0);
    CHECK(hull_faces(std::vector<glm::vec3>(9, glm::vec3(1.0f))).count() == 0);
    std::vector<glm::vec3> line, square;
    for (int i = 0; i < 9; ++i) {
        line.emplace_back(0.1f * static_cast<float>(i), 0.0f, 0.0f);
        square.emplace_back(0.1f * static_cast<float>(i % 3), 0.0f, 0.1f * static_cast<float>(i / 3));
    }
    CHECK(hull_faces(line).count() == 0);
    CHECK(hull_faces(square).count() == 0);
    std::vector<glm::vec3> many = box_corners(glm::vec3(0.5f));
    many.resize(65535, glm::vec3(0.0f));
    CHECK(hull_faces(many).count() == 6);
    many.emplace_back(0.0f);
    CHECK(hull_faces(many).count() == 0);
}

TEST_CASE("hull faces: a cube has six squares, whatever its place and size and the order of its points") {
    test::Random random(2);
    for (const float half : {1e-4f, 0.05f, 1.0f, 100.0f})
        for (int turn = 0; turn < 10; ++turn) {
            std::vector<glm::vec3> points = box_corners(glm::vec3(half));
            // Points on faces, in the middle of edges, inside, and corners that are there twice add nothing.
            for (int axis = 0; axis < 3; ++axis) {
                points.emplace_back(0.0f);
                points.back()[axis] = half;
                points.push_back(glm::vec3(half));
                points.back()[axis] = 0.0f;
            }
            points.emplace_back(0.0f);
            points.push_back(points[2]);
            for (size_t i = points.size(); i-- > 1;)
                std::swap(points[i], points[static_cast<size_t>(random.uniform(0.0, static_cast<double>(i) + 0.999))]);
            if (turn % 2 == 1)
                for (glm::vec3& p : points) p += half * glm::vec3(3.0f, -2.0f, 1.0f);
            const HullFaces faces = hull_faces(points);
            REQUIRE(faces.count() == 6);
            for (size_t face = 0; face < 6; ++face) CHECK(faces.of(face).size() == 4);
            const double sum = check_faces(points, faces, 1e-5);
            CHECK(sum == doctest::Approx(24.0 * static_cast<double>(half) * static_cast<double>(half)).epsilon(1e-5));
            std::vector<glm::vec3> corners;
            for (const uint16_t corner : faces.corners) corners.push_back(points[corner]);
            std::ranges::sort(corners, {}, [](const glm::vec3& p) { return std::tuple(p.x, p.y, p.z); });
            for (size_t i = 0; i < corners.size(); i += 3) CHECK(corners[i] == corners[i + 2]); // three faces at each
            if (turn < 2) check_closed(hull_faces(box_corners(glm::vec3(half))));
        }
}

TEST_CASE("hull faces: nearly coplanar faces merge, faces at five degrees do not") {
    test::Random random(8);
    for (int i = 0; i < 300; ++i) {
        CAPTURE(i);
        std::vector<glm::vec3> points = box_corners(glm::vec3(0.5f));
        for (glm::vec3& p : points) p += glm::vec3(random.point(glm::dvec3(-4e-4), glm::dvec3(4e-4)));
        const HullFaces faces = hull_faces(points);
        CHECK(faces.count() == 6);
        for (size_t face = 0; face < faces.count(); ++face) CHECK(faces.of(face).size() == 4);
        check_faces(points, faces, 4e-3);
        check_closed(faces);
    }
    // A roof over a box.
    for (const double degrees : {0.2, 5.0, 20.0}) {
        std::vector<glm::vec3> points = box_corners(glm::vec3(0.01f));
        const auto rise = static_cast<float>(0.01 * std::tan(degrees * std::numbers::pi / 360.0));
        points.emplace_back(0.0f, 0.01f + rise, -0.01f);
        points.emplace_back(0.0f, 0.01f + rise, 0.01f);
        const HullFaces faces = hull_faces(points);
        CHECK(faces.count() == (degrees < 3.0 ? 6u : 7u));
        check_faces(points, faces, degrees < 3.0 ? 4e-3 : 1e-5);
    }
}

TEST_CASE("hull faces: a thin card keeps both sides and its rim") {
    for (const float thickness : {1e-2f, 1e-3f, 3e-4f}) {
        CAPTURE(thickness);
        const std::vector<glm::vec3> points = box_corners({0.5f, 0.5f * thickness, 0.3f});
        const HullFaces faces = hull_faces(points);
        CHECK(faces.count() == 6);
        const double sum = check_faces(points, faces, 1e-6);
        const double exact = 2.0 * (1.0 * 0.6 + static_cast<double>(thickness) * 1.6);
        CHECK(sum == doctest::Approx(exact).epsilon(1e-4));
        size_t above = 0, below = 0;
        for (size_t face = 0; face < faces.count(); ++face) {
            const glm::dvec3 normal = glm::normalize(area_of(points, faces.of(face)));
            above += normal.y > 0.999 ? 1 : 0;
            below += normal.y < -0.999 ? 1 : 0;
        }
        CHECK(above == 1);
        CHECK(below == 1);
    }
}

TEST_CASE("hull faces: a hull of triangles that do not merge is closed") {
    test::Random random(4);
    size_t triangulated = 0, merged = 0;
    for (int i = 0; i < 400; ++i) {
        CAPTURE(i);
        std::vector<glm::vec3> points;
        const int count = 4 + i % 29;
        for (int k = 0; k < count; ++k) points.emplace_back(random.direction() * 0.5);
        const HullFaces faces = hull_faces(points);
        CHECK(faces.count() >= 4);
        const double sum = check_faces(points, faces, 6e-3);
        const double exact = area_of_mesh(fracture::convex_hull(points));
        CHECK(sum == doctest::Approx(exact).epsilon(2e-3));
        if (faces.count() != 2 * static_cast<size_t>(count) - 4) {
            ++merged;
            continue;
        }
        ++triangulated;
        check_closed(faces);
    }
    CHECK(triangulated > 100);
    CHECK(merged > 20);
}

TEST_CASE("hull faces: pieces have faces of their hull that cover it, and none is lost where a sphere is dense") {
    // Corners of Voronoi cells lie on straight edges up to rounding: slivers between them are no faces.
    std::vector<fracture::Fragments> all;
    for (const uint64_t seed : {1, 2, 3})
        all.push_back(test::voronoi_pieces(glm::dvec3(-0.5), glm::dvec3(0.5), 100, seed));
    for (const char* name : {"animal", "arch", "wall", "icosphere"}) {
        const fracture::TriangleMesh mesh = *fracture::shape(name);
        all.push_back(*fracture::fracture(mesh, fracture::uniform_sites(fracture::bounds(mesh), 100, 1)));
    }
    double lost = 0.0, gained = 0.0;
    for (const fracture::Fragments& fragments : all)
        for (const fracture::Piece& piece : fragments.pieces) {
            const CollisionHull hull = collision_hull(fragments.positions_of(piece), piece.mass.centre_of_mass);
            const HullFaces again = hull_faces(hull.points);
            CHECK(hull.faces.corners == again.corners);
            CHECK(hull.faces.ends == again.ends);
            const double covered = check_faces(hull.points, hull.faces, 6e-3);
            const double whole = area_of_mesh(fracture::convex_hull(hull.points));
            lost = std::max(lost, 1.0 - covered / whole);
            gained = std::max(gained, covered / whole - 1.0);
        }
    MESSAGE("areas: at most a part of ", lost, " less than those of the hulls, ", gained, " more");
    CHECK(lost < 0.005);
    CHECK(gained < 0.03); // outlines of merged faces overlap their neighbours; observed: 0.022
    for (const int count : {100, 500, 2000}) {
        CAPTURE(count);
        std::vector<glm::vec3> points;
        for (const glm::dvec3& p : sphere_points(count, 0.5)) points.emplace_back(p);
        const HullFaces faces = hull_faces(points);
        CHECK(check_faces(points, faces, 6e-3) == doctest::Approx(std::numbers::pi).epsilon(0.05));
    }
    for (const auto& flake : {std::vector<glm::dvec3>{{0, 0, 0}, {0.1, 0, 0.1}, {0.1, 0.1, 0.1}, {0, 0.1, 0}},
                              std::vector<glm::dvec3>{{0, 0, 0}, {0.1, 0.1, 0}}}) {
        const CollisionHull hull = collision_hull(flake, glm::dvec3(0.0));
        CHECK(hull.faces.count() == 6);
        check_faces(hull.points, hull.faces, 1e-5);
    }
}
