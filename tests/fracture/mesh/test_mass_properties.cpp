#include "fracture/mesh/mass_properties.h"

#include <cmath>
#include <numbers>
#include <span>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "fracture/base/random.h"
#include "fracture/shapes/shapes.h"

using namespace brittle::fracture;
using std::numbers::pi;

namespace {

MassProperties mass_of(const TriangleMesh& mesh) {
    return mass_properties(mesh.positions, mesh.triangles);
}

void check_near(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
    CAPTURE(a.x);
    CAPTURE(a.y);
    CAPTURE(a.z);
    CHECK(length(a - b) <= tolerance);
}

void check_near(const glm::dmat3& a, const glm::dmat3& b, double tolerance) {
    for (int k = 0; k < 3; ++k) check_near(a[k], b[k], tolerance);
}

glm::dmat3 diagonal(double x, double y, double z) {
    return {{x, 0, 0}, {0, y, 0}, {0, 0, z}};
}

TriangleMesh box(const glm::dvec3& size) {
    TriangleMesh mesh = cube(1.0);
    for (glm::dvec3& p : mesh.positions) p *= size;
    return mesh;
}

TriangleMesh moved(TriangleMesh mesh, const glm::dmat3& rotation, const glm::dvec3& by) {
    for (glm::dvec3& p : mesh.positions) p = rotation * p + by;
    return mesh;
}

// Returns a rotation matrix by Rodrigues' formula.
glm::dmat3 rotation_about(glm::dvec3 axis, double angle) {
    axis = normalize(axis);
    const glm::dmat3 k({0, axis.z, -axis.y}, {-axis.z, 0, axis.x}, {axis.y, -axis.x, 0});
    return glm::dmat3(1.0) + k * std::sin(angle) + k * k * (1.0 - std::cos(angle));
}

} // namespace

TEST_CASE("an empty mesh has no mass") {
    const MassProperties mass = mass_properties({}, {});
    CHECK(mass.volume == 0.0);
    CHECK(mass.area == 0.0);
    CHECK(mass.centre_of_mass == glm::dvec3(0));
    CHECK(signed_volume({}, {}) == 0.0);
}

TEST_CASE("a flat mesh has area, no volume, no inertia and its centre at the mean of its corners") {
    const std::vector<glm::dvec3> positions = {{0.1, 0.2, 0.3}, {1.1, 0.7, 0.9}, {0.3, 1.7, 0.2}, {9e9, 9e9, 9e9}};
    const std::vector<Triangle> triangles = {{0, 1, 2}, {0, 2, 1}};
    const MassProperties mass = mass_properties(positions, triangles);
    CHECK(mass.volume == doctest::Approx(0.0));
    CHECK(mass.area == doctest::Approx(length(cross(positions[1] - positions[0], positions[2] - positions[0]))));
    check_near(mass.centre_of_mass, (positions[0] + positions[1] + positions[2]) / 3.0, 1e-15);
    CHECK(mass.inertia == glm::dmat3(0.0));
}

TEST_CASE("triangles without area change nothing") {
    TriangleMesh mesh = cube();
    const MassProperties before = mass_of(mesh);
    mesh.triangles.push_back({0, 0, 0});
    mesh.triangles.push_back({1, 2, 1});
    CHECK(mass_of(mesh).volume == before.volume);
    CHECK(mass_of(mesh).inertia == before.inertia);
}

TEST_CASE("a cube and a box have the inertia of the closed formula") {
    const MassProperties unit = mass_of(cube(2.0));
    CHECK(unit.volume == 8.0);
    CHECK(unit.area == 24.0);
    CHECK(unit.centre_of_mass == glm::dvec3(0));
    check_near(unit.inertia, diagonal(16.0 / 3, 16.0 / 3, 16.0 / 3), 1e-14);

    const glm::dvec3 s(1, 2, 3);
    const MassProperties mass = mass_of(box(s));
    CHECK(mass.volume == doctest::Approx(6.0).epsilon(1e-15));
    CHECK(mass.area == doctest::Approx(22.0).epsilon(1e-15));
    check_near(mass.inertia, diagonal(4.0 + 9.0, 9.0 + 1.0, 1.0 + 4.0) * (6.0 / 12.0), 1e-13);
}

TEST_CASE("the corner tetrahedron has the inertia of Tonon's closed form") {
    // Vertices 0, a e_x, b e_y, c e_z: V = abc/6, centre = (a, b, c)/4, and about the centre
    // I_xx = V/80 * 3 (b^2 + c^2), I_xy = V/80 * a b (off-diagonal element of the tensor, sign as below).
    const double a = 1.0, b = 2.0, c = 3.0;
    const std::vector<glm::dvec3> p = {{0, 0, 0}, {a, 0, 0}, {0, b, 0}, {0, 0, c}};
    const std::vector<Triangle> t = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    const MassProperties mass = mass_properties(p, t);
    CHECK(mass.volume == doctest::Approx(1.0).epsilon(1e-15));
    check_near(mass.centre_of_mass, {a / 4, b / 4, c / 4}, 1e-15);
    const double v = 1.0 / 80.0;
    const glm::dmat3 expected({3 * (b * b + c * c) * v, a * b * v, a * c * v},
                              {a * b * v, 3 * (c * c + a * a) * v, b * c * v},
                              {a * c * v, b * c * v, 3 * (a * a + b * b) * v});
    check_near(mass.inertia, expected, 1e-14);
}

TEST_CASE("icospheres converge to the ball's inertia") {
    const double volume = 4.0 / 3.0 * pi;
    double previous = 1.0;
    for (uint32_t k = 2; k < 6; ++k) {
        const MassProperties mass = mass_of(icosphere(k));
        check_near(mass.centre_of_mass, glm::dvec3(0), 1e-15);
        const double error = std::abs(mass.inertia[0][0] / (0.4 * volume) - 1.0);
        CHECK(std::abs(mass.inertia[0][1]) < 1e-13);
        if (k > 2) CHECK(previous / error == doctest::Approx(4.0).epsilon(0.1));
        previous = error;
    }
}

TEST_CASE("a fine torus has the torus's inertia and area") {
    const double r = 0.4, volume = 2 * pi * pi * r * r;
    const MassProperties mass = mass_of(torus(800, 400, 1.0, r));
    CHECK(mass.volume == doctest::Approx(volume).epsilon(1e-4));
    CHECK(mass.area == doctest::Approx(4 * pi * pi * r).epsilon(1e-4));
    check_near(mass.inertia / volume, diagonal(0.5 + 5.0 / 8 * r * r, 1.0 + 0.75 * r * r, 0.5 + 5.0 / 8 * r * r), 2e-4);
}

TEST_CASE("a cavity subtracts its volume and inertia") {
    const MassProperties whole = mass_of(icosphere(3, 1.0));
    const MassProperties cavity = mass_of(icosphere(3, 0.6));
    const MassProperties hollow = mass_of(hollow_sphere(3, 1.0, 0.6));
    CHECK(hollow.volume == doctest::Approx(whole.volume - cavity.volume).epsilon(1e-14));
    CHECK(hollow.area == doctest::Approx(whole.area + cavity.area).epsilon(1e-14));
    check_near(hollow.inertia, whole.inertia - cavity.inertia, 1e-13);
}

TEST_CASE("an inside-out mesh negates volume and inertia and keeps its centre") {
    TriangleMesh mesh = moved(box({1, 2, 3}), glm::dmat3(1.0), {5, 6, 7});
    const MassProperties right = mass_of(mesh);
    for (Triangle& t : mesh.triangles) std::swap(t.x, t.y);
    const MassProperties inverted = mass_of(mesh);
    CHECK(inverted.volume == doctest::Approx(-right.volume).epsilon(1e-15));
    CHECK(inverted.area == doctest::Approx(right.area).epsilon(1e-15));
    check_near(inverted.centre_of_mass, right.centre_of_mass, 1e-14);
    check_near(inverted.inertia, -right.inertia, 1e-13);
}

TEST_CASE("inertia rotates with the mesh and is invariant under translation") {
    Random random(3);
    const TriangleMesh mesh = moved(box({1, 2, 3}), glm::dmat3(1.0), {0.3, -0.2, 0.9});
    const MassProperties still = mass_of(mesh);
    for (int round = 0; round < 20; ++round) {
        const glm::dvec3 axis = random.uniform_in({glm::dvec3(-1), glm::dvec3(1)});
        const glm::dmat3 r = rotation_about(axis, 7.0 * random.uniform());
        const glm::dvec3 by = random.uniform_in({glm::dvec3(-10), glm::dvec3(10)});
        const MassProperties mass = mass_of(moved(mesh, r, by));
        CHECK(mass.volume == doctest::Approx(6.0).epsilon(1e-13));
        check_near(mass.centre_of_mass, r * still.centre_of_mass + by, 1e-13);
        check_near(mass.inertia, r * still.inertia * transpose(r), 1e-12);
    }
}

TEST_CASE("the inertia of two separate boxes obeys the parallel axis theorem") {
    TriangleMesh two = moved(cube(1.0), glm::dmat3(1.0), {-2, 0, 0});
    for (const glm::dvec3& p : cube(1.0).positions) two.positions.push_back(p + glm::dvec3(2, 0, 0));
    for (const Triangle& t : cube(1.0).triangles) two.triangles.push_back(t + Triangle(8));
    const MassProperties mass = mass_of(two);
    CHECK(mass.volume == doctest::Approx(2.0));
    const double across = 2 * (1.0 / 6 + 4.0);
    check_near(mass.inertia, diagonal(2.0 / 6, across, across), 1e-13);
}

TEST_CASE("a mesh a million metres from the origin loses no digit") {
    // The coordinates of the lattice cube are exact at both places, so only the integration can differ.
    const TriangleMesh near = lattice_cube(16, 2.0);
    const MassProperties here = mass_of(near);
    const MassProperties there = mass_of(moved(near, glm::dmat3(1.0), glm::dvec3(1048576.0)));
    CHECK(there.volume == here.volume);
    CHECK(there.area == here.area);
    CHECK(there.centre_of_mass - glm::dvec3(1048576.0) == here.centre_of_mass);
    CHECK(there.inertia == here.inertia);
}

TEST_CASE("thin and tiny solids keep their relative precision") {
    const MassProperties slab = mass_of(box({1, 1, 1e-9}));
    CHECK(slab.volume == doctest::Approx(1e-9).epsilon(1e-13));
    CHECK(slab.inertia[2][2] == doctest::Approx(1e-9 / 6).epsilon(1e-12));
    const MassProperties speck = mass_of(cube(1e-9));
    CHECK(speck.volume / 1e-27 == doctest::Approx(1.0).epsilon(1e-14));
    CHECK(speck.inertia[0][0] / 1e-45 == doctest::Approx(1.0 / 6).epsilon(1e-14));
}

TEST_CASE("a million triangles sum to thirteen digits, in any order") {
    TriangleMesh mesh = lattice_cube(330, 1.0); // 1.3 million triangles
    REQUIRE(mesh.triangles.size() == 1'306'800);
    CHECK(std::abs(mass_of(mesh).volume - 1.0) < 1e-13);
    CHECK(std::abs(mass_of(mesh).area - 6.0) < 6e-13);
    Random random(5);
    for (size_t i = mesh.triangles.size(); i > 1; --i) {
        std::swap(mesh.triangles[i - 1], mesh.triangles[random.next() % i]);
    }
    CHECK(std::abs(mass_of(mesh).volume - 1.0) < 1e-13);
}

TEST_CASE("signed_volume() equals the volume of mass_properties() bit for bit") {
    for (const TriangleMesh& mesh : {icosphere(3), torus(), torus_knot(), cube()}) {
        CHECK(signed_volume(mesh.positions, mesh.triangles) == mass_of(mesh).volume);
    }
}

TEST_CASE("mass_properties() with the box of its positions gives the same bits") {
    for (const TriangleMesh& mesh : {icosphere(2), icosphere(3), torus(), torus_knot(), cube()}) {
        const MassProperties mass = mass_properties(mesh.positions, mesh.triangles, bounds(mesh));
        const MassProperties expected = mass_of(mesh);
        CHECK(mass.volume == expected.volume);
        CHECK(mass.area == expected.area);
        CHECK(mass.centre_of_mass == expected.centre_of_mass);
        CHECK(mass.inertia == expected.inertia);
    }
}

TEST_CASE("the area adds up from any number of triangles") {
    const TriangleMesh mesh = icosphere(3);
    double sum = 0.0;
    for (size_t count = 0; count < 600; ++count) {
        const double area = mass_properties(mesh.positions, std::span(mesh.triangles).first(count)).area;
        CAPTURE(count);
        CHECK(std::abs(area - sum) <= 1e-13);
        sum += mass_properties(mesh.positions, std::span(mesh.triangles).subspan(count, 1)).area;
    }
}
