#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <numeric>
#include <set>
#include <tuple>
#include <vector>

#include "fracture/base/random.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/topology.h"
#include "fracture/sequential/clip.h"
#include "fracture/shapes/shapes.h"

using namespace brittle::fracture;

namespace {

HalfEdgeMesh half_edges(const TriangleMesh& mesh) {
    return *build_half_edges(mesh.positions, mesh.triangles);
}

// The plane n·x = d. Site 0 keeps the side below, site 1 the side above.
Bisector plane(const glm::dvec3& n, double d) {
    return {0, 1, n, n * (d / glm::dot(n, n))};
}

double volume(const HalfEdgeMesh& mesh) {
    return mass_properties(mesh.positions, triangle_list(mesh)).volume;
}

void check_closed(const HalfEdgeMesh& mesh) {
    CHECK(is_valid(mesh));
    CHECK(is_closed(mesh));
    const std::vector<Triangle> triangles = triangle_list(mesh);
    CHECK(describe(check_topology(mesh.positions.size(), triangles)) == "");
}

// The triangles of the mesh with this source.
std::vector<Triangle> with_source(const HalfEdgeMesh& mesh, FaceSource source) {
    std::vector<Triangle> triangles;
    for (uint32_t face = 0; face < mesh.faces.size(); ++face)
        if (mesh.sources[face] == source) triangles.push_back(corners(mesh, face));
    return triangles;
}

std::vector<Triangle> cap_of(const HalfEdgeMesh& mesh, uint32_t across) {
    return with_source(mesh, {.index = across, .interior = true});
}

size_t component_count(const HalfEdgeMesh& mesh, const std::vector<Triangle>& triangles) {
    const auto component = triangle_components(mesh.positions.size(), triangles);
    return std::set(component.begin(), component.end()).size();
}

using Point = std::tuple<double, double, double>;
std::set<Point> points(const HalfEdgeMesh& mesh, const std::vector<Triangle>& triangles) {
    std::set<Point> set;
    for (const Triangle& t : triangles)
        for (int i = 0; i < 3; ++i) {
            const glm::dvec3& p = mesh.positions[t[i]];
            set.insert({p.x, p.y, p.z});
        }
    return set;
}

// Cuts a mesh, checks that both sides are closed and have the volume of the whole, and returns the sides of site 0 and
// 1.
std::array<HalfEdgeMesh, 2> cut_both(const TriangleMesh& mesh, const Bisector& cut) {
    const HalfEdgeMesh whole = half_edges(mesh);
    std::array<HalfEdgeMesh, 2> sides{clip(whole, cut, 0), clip(whole, cut, 1)};
    for (const HalfEdgeMesh& side : sides) check_closed(side);
    CHECK(volume(sides[0]) + volume(sides[1]) == doctest::Approx(volume(whole)).epsilon(1e-12));
    CHECK(points(sides[0], cap_of(sides[0], 1)) == points(sides[1], cap_of(sides[1], 0)));
    return sides;
}

// A tetrahedron with corners a, b, c on the axes and d in the origin; face 0 is abc.
const TriangleMesh tetrahedron{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}},
                               {{0, 1, 2}, {1, 0, 3}, {2, 1, 3}, {0, 2, 3}}};

// The plane with value -1 at the corners of abc that site 0 keeps, 3 at the others, and -offset at d: it meets each
// crossing edge of abc a quarter of the way from the kept end.
Bisector plane_for(CutCase which, double offset) {
    glm::dvec3 n;
    for (int i = 0; i < 3; ++i) n[i] = ((static_cast<int>(which) >> i & 1) ? -1.0 : 3.0) + offset;
    return plane(n, offset);
}

double area(const HalfEdgeMesh& mesh, const std::vector<Triangle>& triangles) {
    return mass_properties(mesh.positions, triangles).area;
}

bool near(const glm::dvec3& p, const glm::dvec3& q) {
    return glm::distance(p, q) < 1e-15;
}

// Whether the triangles have exactly the expected points.
bool has_points(const HalfEdgeMesh& mesh, const std::vector<Triangle>& triangles,
                const std::vector<glm::dvec3>& expected) {
    const std::set<Point> have = points(mesh, triangles);
    return have.size() == expected.size() && std::all_of(expected.begin(), expected.end(), [&](const auto& e) {
               return std::any_of(have.begin(), have.end(), [&](const Point& p) {
                   return near(e, {std::get<0>(p), std::get<1>(p), std::get<2>(p)});
               });
           });
}

// Clips the tetrahedron by the plane of the case, checks the result, and returns the rest of face abc.
struct FaceAfterCut {
    HalfEdgeMesh mesh;
    std::vector<Triangle> triangles;
};
FaceAfterCut cut_face(CutCase which, double offset) {
    const Bisector cut = plane_for(which, offset);
    const auto& p = tetrahedron.positions;
    REQUIRE(cut_case(cut.keeps(0, cut.value(p[0])), cut.keeps(0, cut.value(p[1])), cut.keeps(0, cut.value(p[2])))
            == which);
    FaceAfterCut result{cut_both(tetrahedron, cut)[0], {}};
    result.triangles = with_source(result.mesh, {.index = 0});
    for (const Triangle& t : result.triangles) { // outward orientation is kept
        const auto& q = result.mesh.positions;
        const glm::dvec3 normal = glm::cross(q[t.y] - q[t.x], q[t.z] - q[t.x]);
        CHECK(glm::dot(normal, glm::dvec3(1.0)) > 0.0);
    }
    return result;
}

void check_corner_stays(CutCase which, int corner) {
    for (const double offset : {0.5, -0.5}) { // d is kept, d is cut off
        const FaceAfterCut face = cut_face(which, offset);
        const glm::dvec3 u = tetrahedron.positions[corner];
        const glm::dvec3 v = tetrahedron.positions[(corner + 1) % 3];
        const glm::dvec3 w = tetrahedron.positions[(corner + 2) % 3];
        CHECK(face.triangles.size() == 1);
        CHECK(has_points(face.mesh, face.triangles, {u, u + (v - u) * 0.25, u + (w - u) * 0.25}));
    }
}

void check_side_stays(CutCase which, int corner) {
    for (const double offset : {0.5, -0.5}) {
        const FaceAfterCut face = cut_face(which, offset);
        const glm::dvec3 u = tetrahedron.positions[corner];
        const glm::dvec3 v = tetrahedron.positions[(corner + 1) % 3];
        const glm::dvec3 w = tetrahedron.positions[(corner + 2) % 3];
        CHECK(face.triangles.size() == 2);
        CHECK(has_points(face.mesh, face.triangles, {u, v, v + (w - v) * 0.25, u + (w - u) * 0.25}));
        // The whole minus the similar tetrahedron at w, of 3/4 the size.
        CHECK(area(face.mesh, face.triangles) == doctest::Approx(std::sqrt(3.0) / 2.0 * (1.0 - 9.0 / 16.0)));
    }
}

} // namespace

TEST_CASE("clipping nothing gives nothing") {
    CHECK(clip(HalfEdgeMesh{}, plane({1, 0, 0}, 0), 0).faces.empty());
}

TEST_CASE("case none: a face without kept corners is dropped") {
    CHECK(cut_face(CutCase::none, 0.5).triangles.empty());
    const HalfEdgeMesh gone = clip(half_edges(tetrahedron), plane({1, 1, 1}, -1), 0);
    CHECK(gone.faces.empty());
    CHECK(gone.positions.empty());
}

TEST_CASE("case a: the corner a stays as a triangle") {
    check_corner_stays(CutCase::a, 0);
}
TEST_CASE("case b: the corner b stays as a triangle") {
    check_corner_stays(CutCase::b, 1);
}
TEST_CASE("case c: the corner c stays as a triangle") {
    check_corner_stays(CutCase::c, 2);
}
TEST_CASE("case ab: the side ab stays as a quad") {
    check_side_stays(CutCase::ab, 0);
}
TEST_CASE("case bc: the side bc stays as a quad") {
    check_side_stays(CutCase::bc, 1);
}
TEST_CASE("case ca: the side ca stays as a quad") {
    check_side_stays(CutCase::ca, 2);
}

TEST_CASE("case abc: a face with all corners kept is unchanged") {
    const FaceAfterCut face = cut_face(CutCase::abc, -0.5);
    CHECK(face.triangles.size() == 1);
    CHECK(has_points(face.mesh, face.triangles,
                     {tetrahedron.positions[0], tetrahedron.positions[1], tetrahedron.positions[2]}));
    const HalfEdgeMesh whole = clip(half_edges(tetrahedron), plane({1, 1, 1}, 2), 0);
    CHECK(whole.positions == tetrahedron.positions);
    CHECK(triangle_list(whole) == tetrahedron.triangles);
}

TEST_CASE("a vertex on the plane belongs to the lower site, from both sides") {
    // The plane x = 0 runs through b, c and d.
    const HalfEdgeMesh whole = half_edges(tetrahedron);
    const HalfEdgeMesh above = clip(whole, plane({1, 0, 0}, 0), 1);
    check_closed(above);
    CHECK(volume(above) == doctest::Approx(1.0 / 6.0).epsilon(1e-15));
    const HalfEdgeMesh below = clip(whole, plane({1, 0, 0}, 0), 0); // a sheet without thickness
    check_closed(below);
    CHECK(volume(below) == doctest::Approx(0.0));
    // A plane that only touches the corner d cuts nothing off the side that owns d.
    CHECK(clip(whole, plane({1, 1, 1}, 0), 0).faces.size() > 0);
    CHECK(clip(whole, plane({-1, -1, -1}, 0), 0).faces.size() == whole.faces.size());
}

TEST_CASE("the intersection of an edge is the same from both ends, and exact at the ends") {
    Random random(11);
    const Box box{glm::dvec3(-1.0), glm::dvec3(1.0)};
    for (int i = 0; i < 1000; ++i) {
        const glm::dvec3 p = random.uniform_in(box);
        const glm::dvec3 q = random.uniform_in(box);
        const Bisector cut = plane(q - p + random.uniform_in(box) * 0.3, 0.1);
        if (Bisector::keeps_low(cut.value(p)) == Bisector::keeps_low(cut.value(q))) continue;
        const glm::dvec3 x = intersection(p, q, cut);
        CHECK(x == intersection(q, p, cut));
        CHECK(std::abs(cut.value(x)) < 1e-14);
    }
    // p lies on the plane: the intersection is p to the last bit.
    const glm::dvec3 p{0.1, 0.2, 0.3};
    const Bisector through{0, 1, {1, 2, 3}, p};
    CHECK(intersection(p, {1, 1, 1}, through) == p);
    CHECK(intersection({1, 1, 1}, p, through) == p);
}

TEST_CASE("a quad is cut between its larger angles") {
    const glm::dvec3 p{0, 0, 0};
    const glm::dvec3 q{1, 0, 0};
    const glm::dvec3 r{1, 1, 0};
    const glm::dvec3 s{0, 1, 0};
    CHECK(cut_along_first_diagonal(p, q, r * 0.9, s));       // blunt at p and r
    CHECK_FALSE(cut_along_first_diagonal(p, q, r * 1.1, s)); // blunt at q and s
    CHECK(cut_along_first_diagonal({1e6, 0, 0}, {1e6 + 1, 0, 0}, {1e6 + .9, .9, 0}, {1e6, 1, 0}));
    CHECK(cut_along_first_diagonal(p, p, p, p)); // without angles the answer is arbitrary but fixed
}

TEST_CASE("a cube cut in two has a square cap on each side") {
    const auto sides = cut_both(cube(2.0), plane({1, 0, 0}, 0.25));
    CHECK(volume(sides[0]) == doctest::Approx(5.0));
    CHECK(volume(sides[1]) == doctest::Approx(3.0));
    for (const uint32_t site : {0u, 1u}) {
        const auto cap = cap_of(sides[site], 1 - site);
        CHECK(area(sides[site], cap) == doctest::Approx(4.0));
        for (const Triangle& t : cap) { // faces outwards
            const auto& p = sides[site].positions;
            const double x = glm::cross(p[t.y] - p[t.x], p[t.z] - p[t.x]).x;
            CHECK((site == 0 ? x : -x) >= 0.0);
        }
    }
}

TEST_CASE("the border of a torus cut across is walked as two loops") {
    const TriangleMesh ring = torus(48, 24, 1.0, 0.4);
    const auto sides = cut_both(ring, plane({1, 0, 0}, 0.01));
    for (const uint32_t site : {0u, 1u}) {
        const auto cap = cap_of(sides[site], 1 - site);
        CHECK(component_count(sides[site], cap) == 2);
        CHECK(area(sides[site], cap) == doctest::Approx(2.0 * std::numbers::pi * 0.16).epsilon(0.03));
        // Half a ring is topologically a ball.
        CHECK(check_topology(sides[site].positions.size(), triangle_list(sides[site])).euler_characteristic() == 2);
    }
}

TEST_CASE("a torus cut like a bagel has a cap with a hole in it") {
    const TriangleMesh ring = torus(48, 24, 1.0, 0.4);
    const auto sides = cut_both(ring, plane({0, 1, 0}, 0.01));
    for (const uint32_t site : {0u, 1u}) {
        const auto cap = cap_of(sides[site], 1 - site);
        CHECK(component_count(sides[site], cap) == 1);
        const double annulus = std::numbers::pi * (1.4 * 1.4 - 0.6 * 0.6);
        CHECK(area(sides[site], cap) == doctest::Approx(annulus).epsilon(0.03));
        CHECK(check_topology(sides[site].positions.size(), triangle_list(sides[site])).euler_characteristic() == 0);
    }
}

TEST_CASE("a cut through a hollow sphere leaves a ring that joins shell and cavity") {
    const auto sides = cut_both(hollow_sphere(3, 1.0, 0.6), plane({0.1, 0.2, 1}, 0.1));
    for (const uint32_t site : {0u, 1u}) {
        const auto cap = cap_of(sides[site], 1 - site);
        CHECK(component_count(sides[site], cap) == 1);
        const auto all = check_topology(sides[site].positions.size(), triangle_list(sides[site]));
        CHECK(all.components == 1);
        CHECK(all.euler_characteristic() == 2);
    }
}

TEST_CASE("a concave cut is capped within its outline") {
    // Across a knot a plane meets the tube several times, at all angles.
    for (const double offset : {0.0, 0.05, 0.3, 0.6}) {
        CAPTURE(offset);
        const TriangleMesh knot = torus_knot(2, 3, 200, 16, 0.25);
        cut_both(knot, plane({0.3, 0.1, 1}, offset));
        cut_both(knot, plane({1, 0.2, 0.1}, offset));
    }
}

TEST_CASE("cuts through vertices, edges and faces of a lattice cube stay closed") {
    for (const double d : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
        CAPTURE(d);
        for (const glm::dvec3& n : {glm::dvec3(1, 0, 0), glm::dvec3(0, -1, 0), glm::dvec3(1, 1, 0),
                                    glm::dvec3(0, 1, -1), glm::dvec3(1, 1, 1), glm::dvec3(-1, 2, 1)})
            cut_both(lattice_cube(4, 2.0), plane(n, d));
    }
}

TEST_CASE("many cuts one after the other stay closed") {
    Random random(5);
    const Box box{glm::dvec3(-1.0), glm::dvec3(1.0)};
    for (int round = 0; round < 10; ++round) {
        HalfEdgeMesh mesh = half_edges(torus(24, 12));
        for (int i = 0; i < 12 && !mesh.faces.empty(); ++i) {
            const Bisector cut = plane(random.uniform_in(box), 0.3 * random.uniform());
            const double before = volume(mesh);
            const HalfEdgeMesh rest = clip(mesh, cut, 1);
            mesh = clip(mesh, cut, 0);
            check_closed(mesh);
            CHECK(volume(mesh) + volume(rest) == doctest::Approx(before).epsilon(1e-11));
        }
    }
}
