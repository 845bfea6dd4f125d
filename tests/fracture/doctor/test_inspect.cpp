#include "fracture/doctor/inspect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <boost/multiprecision/cpp_int.hpp>
#include <doctest/doctest.h>

#include "fracture/base/random.h"
#include "fracture/fracture.h"
#include "fracture/io/import.h"
#include "fracture/mesh/intersections.h"
#include "fracture/mesh/thickness.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"

using namespace brittle::fracture;

namespace {

using Rational = boost::multiprecision::cpp_rational;
using Vector = std::array<Rational, 3>;

Vector exact(const glm::dvec3& p) {
    return {Rational(p.x), Rational(p.y), Rational(p.z)};
}
Vector minus(const Vector& a, const Vector& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Rational dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

using Corners = std::array<glm::dvec3, 3>;

// Whether two triangles with area have a common point, by separating axes: the normals, the cross products of sides,
// and in a plane the normals of sides within it. Independent of the code under test, in rational arithmetic.
bool have_common_point(const Corners& s, const Corners& t) {
    std::array<Vector, 3> a{}, b{};
    for (size_t k = 0; k < 3; ++k) {
        a[k] = exact(s[k]);
        b[k] = exact(t[k]);
    }
    const Vector n = cross(minus(a[1], a[0]), minus(a[2], a[0])), m = cross(minus(b[1], b[0]), minus(b[2], b[0]));
    std::vector<Vector> axes{n, m};
    for (size_t i = 0; i < 3; ++i) {
        const Vector u = minus(a[(i + 1) % 3], a[i]);
        axes.push_back(cross(n, u));
        for (size_t j = 0; j < 3; ++j) {
            const Vector v = minus(b[(j + 1) % 3], b[j]);
            axes.push_back(cross(u, v));
            if (i == 0) axes.push_back(cross(m, v));
        }
    }
    for (const Vector& axis : axes) {
        const auto range = [&](const std::array<Vector, 3>& corners) {
            std::array<Rational, 3> at = {dot(axis, corners[0]), dot(axis, corners[1]), dot(axis, corners[2])};
            std::sort(at.begin(), at.end());
            return at;
        };
        const auto x = range(a), y = range(b);
        if (x[2] < y[0] || y[2] < x[0]) return false;
    }
    return true;
}

bool has_area(const Corners& t) {
    const Vector n = cross(minus(exact(t[1]), exact(t[0])), minus(exact(t[2]), exact(t[0])));
    return n[0] != 0 || n[1] != 0 || n[2] != 0;
}

TriangleMesh together(TriangleMesh a, const TriangleMesh& b, const glm::dvec3& offset = glm::dvec3(0.0)) {
    const auto base = static_cast<uint32_t>(a.positions.size());
    for (const glm::dvec3& p : b.positions) a.positions.push_back(p + offset);
    for (const Triangle& t : b.triangles) a.triangles.push_back(t + base);
    return a;
}

TriangleMesh turned(TriangleMesh mesh) {
    for (Triangle& t : mesh.triangles) std::swap(t.y, t.z);
    return mesh;
}

TriangleMesh without(TriangleMesh mesh, size_t triangle) {
    mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(triangle));
    return mesh;
}

TriangleMesh scaled(TriangleMesh mesh, const glm::dvec3& factor) {
    for (glm::dvec3& p : mesh.positions) p *= factor;
    return mesh;
}

// A quarter turn about X.
TriangleMesh stood_up(TriangleMesh mesh) {
    for (glm::dvec3& p : mesh.positions) p = {p.x, -p.z, p.y};
    return mesh;
}

// Merges vertices in one place.
TriangleMesh welded(TriangleMesh mesh) {
    for (Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k)
            t[k] = static_cast<uint32_t>(std::find(mesh.positions.begin(), mesh.positions.end(), mesh.positions[t[k]])
                                         - mesh.positions.begin());
    return mesh;
}

// The side of a cylinder.
TriangleMesh tube(uint32_t sides) {
    TriangleMesh mesh;
    for (uint32_t k = 0; k < sides; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / sides;
        for (const double y : {-1.0, 1.0}) mesh.positions.emplace_back(std::cos(angle), y, std::sin(angle));
        const uint32_t a = 2 * k, b = 2 * ((k + 1) % sides);
        mesh.triangles.emplace_back(a, a + 1, b + 1);
        mesh.triangles.emplace_back(a, b + 1, b);
    }
    return mesh;
}

TriangleMesh moebius(uint32_t steps) {
    TriangleMesh mesh;
    for (uint32_t k = 0; k < steps; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / steps;
        for (const double side : {-0.3, 0.3}) {
            const double r = 1.0 + side * std::cos(0.5 * angle);
            mesh.positions.emplace_back(r * std::cos(angle), side * std::sin(0.5 * angle), r * std::sin(angle));
        }
        const uint32_t a = 2 * k, b = 2 * ((k + 1) % steps), twist = k + 1 == steps ? 1 : 0;
        mesh.triangles.emplace_back(a, a + 1, b + (1 - twist));
        mesh.triangles.emplace_back(a, b + (1 - twist), b + twist);
    }
    return mesh;
}

TriangleMesh with_back(TriangleMesh mesh, size_t triangle) {
    const Triangle t = mesh.triangles[triangle];
    mesh.triangles.emplace_back(t.x, t.z, t.y);
    return mesh;
}

// Adds a triangle that stands on an edge and leans outwards. The sides of its other neighbours count as touched.
TriangleMesh with_fin(TriangleMesh mesh, size_t triangle) {
    const Triangle t = mesh.triangles[triangle];
    mesh.positions.push_back(-0.5 * (mesh.positions[t.x] + mesh.positions[t.y])); // inwards, through the opposite side
    mesh.positions.back() *= 3.0;
    mesh.triangles.emplace_back(t.x, t.y, static_cast<uint32_t>(mesh.positions.size() - 1));
    return mesh;
}

// A tall box of two cubes, including the square between them.
TriangleMesh with_wall() {
    TriangleMesh mesh;
    for (const double y : {0.0, 1.0, 2.0})
        for (const double x : {0.0, 1.0})
            for (const double z : {0.0, 1.0}) mesh.positions.emplace_back(x, y, z);
    const auto quad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
        mesh.triangles.emplace_back(a, b, c);
        mesh.triangles.emplace_back(a, c, d);
    };
    quad(0, 2, 3, 1);   // below
    quad(8, 9, 11, 10); // above
    for (const uint32_t base : {0u, 4u}) {
        quad(base + 1, base + 3, base + 7, base + 5);
        quad(base + 3, base + 2, base + 6, base + 7);
        quad(base + 2, base + 0, base + 4, base + 6);
        quad(base + 0, base + 1, base + 5, base + 4);
    }
    quad(4, 5, 7, 6);
    return mesh;
}

TriangleMesh half_turned(TriangleMesh mesh) {
    for (size_t t = 0; t < mesh.triangles.size() / 2; ++t) std::swap(mesh.triangles[t].y, mesh.triangles[t].z);
    return mesh;
}

TriangleMesh crumpled() {
    TriangleMesh mesh = icosphere(2);
    Random random(9);
    for (glm::dvec3& p : mesh.positions) p *= 0.3 + random.uniform();
    for (size_t v = 0; v + 1 < mesh.positions.size(); v += 7) std::swap(mesh.positions[v], mesh.positions[v + 1]);
    return mesh;
}

// A tetrahedron with a vertex in the middle of an edge: one of the two triangles there overlaps it.
TriangleMesh with_flat_side() {
    return {{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {1, 0, 0}},
            {{0, 2, 1}, {0, 4, 3}, {4, 1, 3}, {0, 3, 2}, {1, 2, 3}, {0, 1, 4}}};
}

} // namespace

TEST_CASE("intersections: orientation is exact on a lattice and beside it") {
    Random random(1);
    for (int k = 0; k < 3000; ++k) {
        std::array<glm::dvec3, 4> p{};
        for (glm::dvec3& at : p) {
            for (int axis = 0; axis < 3; ++axis) at[axis] = static_cast<double>(random.next() % 4) * 0.1;
            if (k % 3 == 0) at += glm::dvec3(1e6);
        }
        const Vector d = exact(p[3]);
        const Rational det = dot(minus(exact(p[0]), d), cross(minus(exact(p[1]), d), minus(exact(p[2]), d)));
        CHECK(orientation(p[0], p[1], p[2], p[3]) == (det > 0 ? 1 : (det < 0 ? -1 : 0)));
    }
}

TEST_CASE("intersections: pairs of triangles, against separating axes in fractions") {
    Random random(2);
    int met = 0, apart = 0;
    for (int k = 0; k < 6000; ++k) {
        TriangleMesh mesh;
        // On a coarse lattice most pairs are degenerate: coplanar, touching in a point, side on side.
        const uint64_t steps = 2 + random.next() % 3;
        for (int v = 0; v < 6; ++v)
            mesh.positions.push_back({static_cast<double>(random.next() % (steps + 1)),
                                      static_cast<double>(random.next() % (steps + 1)),
                                      static_cast<double>(random.next() % (k % 2 == 0 ? 2 : steps + 1))});
        const Corners a = {mesh.positions[0], mesh.positions[1], mesh.positions[2]},
                      b = {mesh.positions[3], mesh.positions[4], mesh.positions[5]};
        if (!has_area(a) || !has_area(b)) continue;
        mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
        const bool expected = have_common_point(a, b);
        (expected ? met : apart) += 1;
        CHECK(find_intersections(mesh, 100).pairs == (expected ? 1 : 0));
    }
    CHECK(met > 500);
    CHECK(apart > 500);
}

TEST_CASE("intersections: neighbours do not count, unless they fold onto each other") {
    for (const TriangleMesh& mesh : {cube(), lattice_cube(6), icosphere(3), torus(32, 16), torus_knot(),
                                     hollow_sphere(2), menger_sponge(2), four_legged_animal(32)}) {
        CAPTURE(mesh.triangles.size());
        const Intersections found = find_intersections(mesh, 100'000'000);
        CHECK(found.pairs == 0);
        CHECK(found.complete);
    }
    // Two triangles on the same side of their common edge.
    const TriangleMesh folded{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.5, 0}}, {{0, 1, 2}, {1, 0, 3}}};
    CHECK(find_intersections(folded, 100).pairs == 1);
    const TriangleMesh flat{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, -0.5, 0}}, {{0, 1, 2}, {1, 0, 3}}};
    CHECK(find_intersections(flat, 100).pairs == 0);
    // A triangle through the side opposite to the common vertex.
    const TriangleMesh pierced{{{0, 0, 0}, {2, 1, 0}, {2, -1, 0}, {3, 0, 1}, {3, 0, -1}}, {{0, 1, 2}, {0, 3, 4}}};
    CHECK(find_intersections(pierced, 100).pairs == 1);
}

TEST_CASE("intersections: the number of tests is bounded and reported") {
    TriangleMesh crowd;
    for (int k = 0; k < 300; ++k) crowd = together(std::move(crowd), cube());
    const Intersections found = find_intersections(crowd, 1000);
    CHECK_FALSE(found.complete);
    CHECK(found.pairs <= 1000);
}

TEST_CASE("inspect: the refusals of fifty sound and broken meshes agree with fracture") {
    const TriangleMesh ball = icosphere(2), box = cube();
    TriangleMesh flipped = ball, doubled = ball, shared_edge = box, nan = ball, outside = ball, twice = ball,
                 flat = ball;
    std::swap(flipped.triangles[7].x, flipped.triangles[7].y);
    doubled.triangles.push_back(doubled.triangles[5]);
    shared_edge = together(box, box, {2.0, 2.0, 0.0}); // two cubes that share an edge after welding
    for (Triangle& t : shared_edge.triangles)
        for (int k = 0; k < 3; ++k)
            for (uint32_t v = 0; v < 8; ++v)
                if (t[k] >= 8 && shared_edge.positions[t[k]] == shared_edge.positions[v]) t[k] = v;
    nan.positions[3].x = std::numeric_limits<double>::quiet_NaN();
    outside.triangles[0].x = 99999;
    twice.triangles[0].x = twice.triangles[0].y;
    for (glm::dvec3& p : flat.positions) p.z = 0.0;
    struct Expected {
        const char* name;
        TriangleMesh mesh;
        std::optional<Status> refusal;
        uint64_t rims, cavities, inside_out, crossings;
    };
    constexpr uint64_t some = ~uint64_t{0}; // at least one
    const Expected all[] = {
        {"a ball", ball, {}, 0, 0, 0, 0},
        {"a cube", box, {}, 0, 0, 0, 0},
        {"a hollow ball", hollow_sphere(2), {}, 0, 1, 0, 0},
        {"two balls apart", together(ball, ball, {3, 0, 0}), {}, 0, 0, 0, 0},
        {"two balls that overlap", together(ball, ball, {1, 0, 0}), {}, 0, 0, 0, some},
        {"a ball in a ball, both outwards", together(icosphere(2, 2.0), ball), {}, 0, 0, 0, 0},
        {"two cubes face to face", together(box, box, {2, 0, 0}), {}, 0, 0, 0, some},
        {"a ball and one inwards beside it", together(icosphere(2, 2.0), turned(ball), {5, 0, 0}),
         Status::inverted_part, 0, 0, 1, 0},
        {"a triangle missing", without(ball, 4), Status::not_closed, 1, 0, 0, 0},
        {"two holes", without(without(ball, 300), 4), Status::not_closed, 2, 0, 0, 0},
        {"a triangle turned", flipped, Status::not_oriented, 0, 0, 0, 0},
        {"a triangle twice", doubled, Status::non_manifold, 0, 0, 0, 0},
        {"two cubes along an edge", shared_edge, Status::non_manifold, 0, 0, 0, 0},
        {"inside out", turned(ball), Status::inside_out, 0, 0, 1, 0},
        {"pressed flat", flat, Status::no_volume, 0, 0, 0, some},
        {"not a number", nan, Status::invalid_mesh, 0, 0, 0, 0},
        {"an index too high", outside, Status::invalid_mesh, 0, 0, 0, 0},
        {"nothing", {}, Status::empty_mesh, 0, 0, 0, 0},
        {"no triangles", {ball.positions, {}}, Status::empty_mesh, 0, 0, 0, 0},
        {"a ring", torus(24, 12), {}, 0, 0, 0, 0},
        {"a knot", torus_knot(), {}, 0, 0, 0, 0},
        {"a sponge", menger_sponge(2), {}, 0, 0, 0, 0},
        {"a lattice cube", lattice_cube(4), {}, 0, 0, 0, 0},
        {"an animal", four_legged_animal(24), {}, 0, 0, 0, 0},
        {"two rings, linked",
         together(torus(24, 12, 1.0, 0.2), stood_up(torus(24, 12, 1.0, 0.2)), {1, 0, 0}),
         {},
         0,
         0,
         0,
         0},
        {"two rings that cut each other",
         together(torus(24, 12, 1.0, 0.2), stood_up(torus(24, 12, 1.0, 0.2))),
         {},
         0,
         0,
         0,
         some},
        {"two cubes at a corner", welded(together(box, box, {2, 2, 2})), {}, 0, 0, 0, 0},
        {"two balls that touch in a point unwelded", together(cube(), cube(), {2, 2, 2}), {}, 0, 0, 0, some},
        {"a box without its lid", without(without(box, 0), 0), Status::not_closed, 1, 0, 0, 0},
        {"a tube", tube(16), Status::not_closed, 2, 0, 0, 0},
        {"a Moebius strip", moebius(24), Status::not_closed, 1, 0, 0, 0},
        {"one triangle", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}, Status::not_closed, 1, 0, 0, 0},
        {"a triangle and its back",
         {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}},
         Status::no_volume,
         0,
         0,
         0,
         0},
        {"a triangle with its back inside a ball's surface", with_back(ball, 11), Status::non_manifold, 0, 0, 0, 0},
        {"a fin on a ball", with_fin(ball, 3), Status::not_closed, 1, 0, 0, some},
        {"a box with a wall in it", with_wall(), Status::non_manifold, 0, 0, 0, 0},
        {"half of a ball turned", half_turned(ball), Status::not_oriented, 0, 0, 0, 0},
        {"a ball inwards in a ball inwards", together(turned(icosphere(2, 2.0)), turned(ball)), Status::inside_out, 0,
         0, 2, 0},
        {"a thin plate", scaled(box, {1, 0.001, 1}), {}, 0, 0, 0, 0},
        {"a thin shell", hollow_sphere(4, 1.0, 0.99), {}, 0, 1, 0, 0},
        {"a ball in a hollow ball", together(hollow_sphere(2, 1.0, 0.6), icosphere(2, 0.3)), {}, 0, 1, 0, 0},
        {"a cavity that comes out",
         together(icosphere(3), turned(icosphere(3, 0.8)), {0.4, 0, 0}),
         {},
         0,
         some,
         0,
         some},
        {"a crumpled ball", crumpled(), {}, 0, 0, 0, some},
        {"a tube too thick for its knot", torus_knot(2, 3, 96, 12, 0.9), {}, 0, 0, 0, some},
        // The neighbours of the flat triangle overlap along it.
        {"a side of no area", with_flat_side(), {}, 0, 0, 0, some},
        {"too far out to compute with", scaled(ball, glm::dvec3(1e60)), Status::invalid_mesh, 0, 0, 0, 0},
        {"infinite", scaled(ball, glm::dvec3(std::numeric_limits<double>::infinity())), Status::invalid_mesh, 0, 0, 0,
         0},
        {"a nanometre large", scaled(ball, glm::dvec3(1e-9)), {}, 0, 0, 0, 0},
        {"a million metres off", together({}, ball, glm::dvec3(1e6)), {}, 0, 0, 0, 0},
        {"with vertices that nothing uses", together({{{9, 9, 9}}, {}}, ball), {}, 0, 0, 0, 0},
    };
    for (const Expected& expected : all) {
        INFO(expected.name);
        const Inspection found = inspect(expected.mesh);
        CHECK(found.refusal == expected.refusal);
        CHECK(found.rims.size() == expected.rims);
        const auto count = [&](auto member) {
            return static_cast<uint64_t>(std::count_if(found.components.begin(), found.components.end(),
                                                       [&](const auto& c) { return c.*member; }));
        };
        if (expected.cavities == some) {
            CHECK(count(&Inspection::Component::is_cavity) + count(&Inspection::Component::is_inside_out) == 1);
            continue; // partly inside: both answers are right, and fracture() uses winding numbers
        }
        CHECK(count(&Inspection::Component::is_cavity) == expected.cavities);
        CHECK(count(&Inspection::Component::is_inside_out) == expected.inside_out);
        if (expected.crossings == some) {
            CHECK(found.intersections > 0);
        } else {
            CHECK(found.intersections == expected.crossings);
        }
        CHECK(found.places.crossings.size() == std::min<uint64_t>(found.intersections, 1000));
        CHECK(found.places.open_edges.size() == std::min<uint64_t>(found.topology.open_edges, 1000));
        CHECK(found.places.misoriented_edges.size() == std::min<uint64_t>(found.topology.misoriented_edges, 1000));
        CHECK(found.places.non_manifold_edges.size() == std::min<uint64_t>(found.topology.non_manifold_edges, 1000));
        CHECK(found.places.non_manifold_vertices.size() == found.topology.non_manifold_vertices);
        CHECK_FALSE(describe(found).empty());
        // The answer of fracture() itself.
        const auto result = fracture(expected.mesh, uniform_sites({glm::dvec3(-1.0), glm::dvec3(1.0)}, 4, 1));
        // Where a surface crosses itself, it depends on the cut whether a piece is inside out.
        if (!result && found.intersections > 0 && result.error().status == Status::inverted_part) continue;
        CHECK(bool(result) == !expected.refusal.has_value());
        if (!result) CHECK(result.error().status == *expected.refusal);
    }
    CHECK(inspect(twice).refusal.has_value()); // a triangle that names a vertex twice opens the surface as well
    CHECK(inspect(doubled).duplicate_triangles == 1);
    CHECK(*inspect(doubled).first_duplicate == glm::uvec2(320, 5));
}

TEST_CASE("inspect: the thickness of a solid is measured") {
    const TriangleMesh box = cube(2.0);
    const Thickness through(box);
    for (uint32_t t = 0; t < box.triangles.size(); ++t) {
        const Triangle& c = box.triangles[t];
        const glm::dvec3 inner = 0.5 * box.positions[c.x] + 0.3 * box.positions[c.y] + 0.2 * box.positions[c.z];
        REQUIRE(through.at(t, inner));
        CHECK(*through.at(t, inner) == doctest::Approx(2.0));
    }
    const TriangleMesh shell = hollow_sphere(4, 1.0, 0.9);
    const Inspection found = inspect(shell);
    REQUIRE(found.min_thickness);
    CHECK(*found.min_thickness == doctest::Approx(0.1).epsilon(0.05));
    CHECK(found.thin_share == 0.0); // a hundredth of the diagonal is 0.035
    const Inspection thin = inspect(hollow_sphere(4, 1.0, 0.99));
    CHECK(thin.thin_share > 0.4); // the outer surface; the wall of the cavity counts too
    CHECK(thin.places.thin_triangles.size() == 1000);
    CHECK(describe(thin).find("thinner than") != std::string::npos);
    CHECK_FALSE(inspect({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}).min_thickness);
    // Of many triangles some are measured, all over the mesh: a thin plate behind a thick ball.
    TriangleMesh both = icosphere(3, 1.0);
    const auto first = static_cast<uint32_t>(both.positions.size()),
               of_ball = static_cast<uint32_t>(both.triangles.size());
    const TriangleMesh plate = cuboid({2.0, 0.01, 2.0});
    for (const glm::dvec3& p : plate.positions) both.positions.push_back(p + glm::dvec3(5.0, 0.0, 0.0));
    for (const Triangle& t : plate.triangles) both.triangles.push_back(t + Triangle(first));
    const Inspection some = inspect(both, {.max_measured = 200});
    REQUIRE(some.min_thickness);
    CHECK(*some.min_thickness == doctest::Approx(0.01));
    CHECK(some.thinnest_triangle >= of_ball);
    CHECK(some.thin_share > 0.0);
    CHECK(some.thin_share < 1.0);
}

TEST_CASE("inspect: published models") {
    const std::string models = "/usr/share/glmark2/models/";
    const auto bunny = import_mesh(models + "bunny.obj"), cat = import_mesh(models + "cat.3ds"),
               horse = import_mesh(models + "horse.3ds"), crate = import_mesh(BRITTLE_CORPUS "/meshes/crate.glb");
    REQUIRE((bunny && cat && horse && crate));
    CHECK(inspect(*bunny).refusal == std::nullopt);
    CHECK(inspect(*bunny).intersections == 2);
    CHECK(inspect(*cat).refusal == Status::not_closed);
    CHECK(inspect(*cat).rims.size() == 5);
    CHECK(inspect(*horse).refusal == Status::non_manifold);
    CHECK(inspect(*horse).topology.non_manifold_edges == 24);
    const Inspection of_crate = inspect(*crate);
    CHECK(of_crate.refusal == std::nullopt);
    CHECK(of_crate.components.size() == 2);
    CHECK(of_crate.intersections == 0); // the knob floats above the lid
}

TEST_CASE("inspect: flat triangles, unused vertices and rims are counted") {
    TriangleMesh mesh = without(lattice_cube(2), 0);
    mesh.positions.push_back({9.0, 9.0, 9.0});
    mesh.triangles.push_back({20, 20, 20});
    const Inspection found = inspect(mesh);
    CHECK(found.unused_vertices == 1);
    CHECK(found.flat_triangles == 1);
    CHECK(*found.first_flat_triangle == mesh.triangles.size() - 1);
    CHECK(found.box.max.x == 1.0); // without the stray vertex
    REQUIRE(found.rims.size() == 1);
    CHECK(found.rims[0].edges >= 3);
    CHECK(found.rims[0].length == doctest::Approx(2.0 + std::sqrt(2.0)));
    const std::string text = describe(found);
    for (const char* word : {"holes", "flat", "unused", "refuses it: the surface has holes"})
        CHECK(text.find(word) != std::string::npos);
}
