#include "physics/cutting/convex_parts.h"

#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/mesh/convex_hull.h"
#include "fracture/mesh/inside.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/shapes/shapes.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

struct Parts {
    fracture::MassProperties mass;
    std::vector<BodyPart> parts;
    double hulls = 0.0; // m^3, sum over all hulls
};

Parts parts_of(const fracture::TriangleMesh& mesh, const ConvexPartSettings& settings = {}) {
    Parts made;
    made.mass = fracture::mass_properties(mesh.positions, mesh.triangles);
    made.parts = convex_parts(mesh.positions, mesh.triangles, made.mass.volume, made.mass.centre_of_mass, settings);
    for (const BodyPart& part : made.parts) {
        const fracture::TriangleMesh hull = fracture::convex_hull(part.hull->points);
        made.hulls += fracture::signed_volume(hull.positions, hull.triangles);
    }
    return made;
}

bool in_some_hull(const Parts& made, const glm::dvec3& point) {
    return std::ranges::any_of(made.parts, [&](const BodyPart& part) {
        const fracture::TriangleMesh hull = fracture::convex_hull(part.hull->points);
        const glm::dvec3 local = point - made.mass.centre_of_mass - glm::dvec3(part.offset);
        return std::ranges::all_of(hull.triangles, [&](const fracture::Triangle& t) {
            const glm::dvec3 &a = hull.positions[t.x], &b = hull.positions[t.y], &c = hull.positions[t.z];
            return glm::dot(glm::cross(b - a, c - a), local - a) <= 0.0;
        });
    });
}

} // namespace

TEST_CASE("convex parts: a convex mesh is one part, also without triangles, volume or width") {
    CHECK(parts_of(fracture::cube()).parts.size() == 1);
    CHECK(parts_of(fracture::icosphere(3)).parts.size() == 1);
    CHECK(convex_parts({}, {}, 0.0, glm::dvec3(0.0)).size() == 1);
    CHECK(parts_of(fracture::cuboid({1.0, 1.0, 1e-7})).parts.size() == 1);
    CHECK(parts_of(fracture::cuboid({1.0, 1e-5, 1e-5})).parts.size() == 1);
}

TEST_CASE("convex parts: a concave mesh is cut until its hulls are full, within the limits") {
    for (const char* name : {"torus", "arch", "torus_knot", "animal", "menger_sponge"}) {
        CAPTURE(name);
        const fracture::TriangleMesh mesh = *fracture::shape(name);
        const Parts one = parts_of(mesh, {.max_parts = 1}), many = parts_of(mesh);
        CHECK(one.parts.size() == 1);
        CHECK(many.parts.size() > 1);
        CHECK(many.parts.size() <= 24);
        CHECK(many.hulls < one.hulls);
        CHECK(parts_of(mesh, {.max_parts = 8}).parts.size() <= 8);
        const Parts again = parts_of(mesh);
        REQUIRE(again.parts.size() == many.parts.size());
        for (size_t i = 0; i < many.parts.size(); ++i) {
            CHECK(again.parts[i].offset == many.parts[i].offset);
            CHECK(again.parts[i].hull->points == many.parts[i].hull->points);
        }
    }
}

TEST_CASE("convex parts: those of a ring leave its hole free and cover its body") {
    const fracture::TriangleMesh mesh = fracture::torus();
    const Parts made = parts_of(mesh);
    const fracture::InsideTest inside(mesh);
    CHECK_FALSE(in_some_hull(made, glm::dvec3(0.0)));
    CHECK_FALSE(in_some_hull(made, glm::dvec3(0.3, 0.0, 0.0)));
    fracture::Random random(5);
    int covered = 0, solid = 0, wrong = 0, empty = 0;
    for (int i = 0; i < 4000; ++i) {
        const glm::dvec3 p = random.uniform_in(fracture::bounds(mesh));
        const bool hull = in_some_hull(made, p);
        (inside(p) ? solid : empty) += 1;
        if (inside(p) && hull) ++covered;
        if (!inside(p) && hull) ++wrong;
    }
    MESSAGE(made.parts.size(), " parts cover ", covered, " of ", solid, " points, and ", wrong, " of ", empty,
            " empty ones");
    CHECK(covered > solid * 8 / 10);
    CHECK(wrong < solid * 3 / 10);
}

TEST_CASE("convex parts: a mesh too large for single precision is one part, as if it were convex") {
    fracture::TriangleMesh ring = *fracture::shape("torus");
    for (glm::dvec3& p : ring.positions) p *= 1e39;
    const double volume = fracture::signed_volume(ring.positions, ring.triangles);
    CHECK(convex_parts(ring.positions, ring.triangles, volume, glm::dvec3(0.0)).size() == 1);
}

TEST_CASE("convex parts: the candidates of a hull are few and span nearly all of it") {
    CHECK(hull_candidates({}).empty());
    const std::vector<glm::dvec3> same(5000, glm::dvec3(2.0));
    CHECK(hull_candidates(same).size() <= 1);
    const fracture::TriangleMesh ball = fracture::icosphere(6);
    const std::vector<glm::dvec3> few = hull_candidates(ball.positions);
    CHECK(few.size() <= 600);
    const std::vector<glm::vec3> points(few.begin(), few.end());
    const fracture::TriangleMesh hull = fracture::convex_hull(points);
    CHECK(fracture::signed_volume(hull.positions, hull.triangles) > 0.98 * 4.18879);
    const fracture::TriangleMesh lattice = fracture::lattice_cube(32);
    const std::vector<glm::dvec3> corners = hull_candidates(lattice.positions);
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0})
            for (const double z : {-1.0, 1.0}) CHECK(std::ranges::find(corners, glm::dvec3(x, y, z)) != corners.end());
}
