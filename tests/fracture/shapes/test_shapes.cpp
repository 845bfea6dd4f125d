#include "fracture/shapes/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/mesh/intersections.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/topology.h"

using namespace brittle::fracture;
using std::numbers::pi;

namespace {

void check_solid(const TriangleMesh& mesh, uint64_t components, int64_t euler) {
    const TopologyReport report = check_topology(mesh.positions.size(), mesh.triangles);
    CHECK_MESSAGE(report.manifold(), describe(report));
    CHECK(report.components == components);
    CHECK(report.euler_characteristic() == euler);
    CHECK(report.vertices == mesh.positions.size());
}

double volume(const TriangleMesh& mesh) {
    return signed_volume(mesh.positions, mesh.triangles);
}

// Returns the count of triangle corners that face away from the area-weighted normal of their vertex.
int count_folded_corners(const TriangleMesh& mesh) {
    const auto area_vector = [&](const Triangle& t) {
        return cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
    };
    std::vector<glm::dvec3> normals(mesh.positions.size(), glm::dvec3(0.0));
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) normals[t[k]] += area_vector(t);
    int folded = 0;
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) folded += dot(area_vector(t), normals[t[k]]) <= 0.0;
    return folded;
}

} // namespace

TEST_CASE("counts out of range are clamped and still give solids") {
    check_solid(lattice_cube(0), 1, 2);
    check_solid(torus(0, 1), 1, 0);
    check_solid(torus_knot(0, 0, 0, 0), 1, 0);
    check_solid(icosphere(0), 1, 2);
    check_solid(four_legged_animal(0), 1, 2);
}

TEST_CASE("household shapes are solids that stand on the ground, with the volumes of their frusta and steps") {
    CHECK(lathe({}, 8).triangles.empty());
    const std::vector<glm::dvec2> profile{{1.0, 0.0}, {2.0, 1.0}, {0.5, 3.0}};
    for (const uint32_t sides : {0u, 3u, 8u, 400u}) {
        const double n = std::max(sides, 3u), share = n * std::sin(2.0 * pi / n) / 2.0; // area of an n-gon of radius 1
        const double frusta = 1.0 * (1.0 + 2.0 + 4.0) / 3.0 + 2.0 * (4.0 + 1.0 + 0.25) / 3.0;
        check_solid(lathe(profile, sides), 1, 2);
        CHECK(volume(lathe(profile, sides)) == doctest::Approx(share * frusta).epsilon(1e-12));
    }
    for (const TriangleMesh& mesh : {vase(), plate(), round_table(), basin(), vase(0), plate(7), stairs(1)}) {
        check_solid(mesh, 1, 2);
        CHECK(bounds(mesh).min.y == 0.0);
        CHECK(volume(mesh) > 0.0);
        CHECK_FALSE(find_intersections(mesh, 10'000'000).first);
    }
    for (const uint32_t steps : {0u, 1u, 2u, 12u, 40u}) {
        const double n = std::max(steps, 1u);
        check_solid(stairs(steps), 1, 2);
        CHECK(volume(stairs(steps)) == doctest::Approx(1.2 * 0.3 * 0.17 * n * (n + 1.0) / 2.0).epsilon(1e-12));
    }
}

TEST_CASE("cuboids and the arch have their volumes") {
    CHECK(volume(cuboid({2.0, 1.4, 0.03})) == doctest::Approx(2.0 * 1.4 * 0.03).epsilon(1e-14));
    for (const uint32_t segments : {2u, 7u, 24u, 100u}) {
        const TriangleMesh mesh = arch(segments);
        CHECK(describe(check_topology(mesh.positions.size(), mesh.triangles)) == "");
        // The rectangle of the outline minus the opening, which is a rectangle below half of a regular polygon with 2 n
        // sides.
        const double polygon = 0.5 * segments * 0.36 * std::sin(std::numbers::pi / segments);
        CHECK(volume(mesh) == doctest::Approx(0.3 * (2.0 * 1.5 - 1.2 * 0.7 - polygon)).epsilon(1e-12));
    }
}

TEST_CASE("shapes of several solids: they touch nowhere, and have their volumes") {
    struct Case {
        TriangleMesh mesh;
        size_t solids;
        double volume; // of all
    };
    const double wedge = std::sin(pi / 15.0); // area of a stone without joint, per mean radius and thickness
    const std::vector<Case> cases = {
        {stone_arch(0.2, 15, 1e-9), 15, 15 * 0.5 * 0.2 * wedge},
        {stone_arch(0.0, 1), 3, 3 * 0.5 * 0.01 * std::sin(pi / 3.0)}, // clamped
        {card_house(0), 2, 2 * 0.088 * 0.063 * 0.002},
        {card_house(4), 26, 26 * 0.088 * 0.063 * 0.002},
        {domino_spiral(0), 1, 0.048 * 0.024 * 0.0075},
        {domino_spiral(200), 200, 200 * 0.048 * 0.024 * 0.0075},
        {pyramid(0), 1, 1.0},
        {pyramid(10, 0.5), 55, 55 * 0.125},
        {stack(0), 1, 1.0},
        {stack(20, 0.1), 20, 20 * 1e-3},
    };
    for (const Case& c : cases) {
        CAPTURE(c.solids);
        const TopologyReport report = check_topology(c.mesh.positions.size(), c.mesh.triangles);
        CHECK(report.manifold());
        CHECK(report.components == c.solids);
        CHECK(volume(c.mesh) == doctest::Approx(c.volume).epsilon(1e-3)); // joints take a little
        CHECK(bounds(c.mesh).min.y > -1e-3);                              // a joint
        CHECK(find_intersections(c.mesh, 10'000'000).pairs == 0);
    }
}

TEST_CASE("the tower is a tube with three windows, and has its volume") {
    const TriangleMesh mesh = tower();
    check_solid(mesh, 1, 2 - 2 * (1 + 3));
    CHECK(bounds(mesh).min.y == 0.0);
    CHECK(bounds(mesh).max.y == 2.0);
    // Frustums over a regular polygon with 48 sides minus the shaft, times the fraction without door, windows and the
    // gaps of the parapet.
    const auto ring = [](double height, double below, double above, int sides) {
        const double triangle = 0.5 * std::sin(2.0 * pi / 48.0);
        return sides * triangle * height * ((below * below + below * above + above * above) / 3.0 - 0.27 * 0.27);
    };
    const double expected = ring(0.12, 0.46, 0.42, 42) + ring(0.38, 0.42, 0.4, 42) + ring(0.3, 0.4, 0.385, 48)
                            + ring(0.25, 0.385, 0.375, 42) + ring(0.35, 0.375, 0.36, 48) + ring(0.12, 0.36, 0.43, 48)
                            + ring(0.2, 0.43, 0.43, 48) + ring(0.28, 0.43, 0.43, 32);
    CHECK(volume(mesh) == doctest::Approx(expected).epsilon(1e-12));
}

TEST_CASE("cubes have their exact volume") {
    check_solid(cube(), 1, 2);
    CHECK(cube().triangles.size() == 12);
    CHECK(volume(cube()) == 8.0);
    CHECK(volume(cube(0.5)) == 0.125);
    for (const uint32_t n : {2u, 3u, 16u}) {
        const TriangleMesh mesh = lattice_cube(n, 2.0);
        check_solid(mesh, 1, 2);
        CHECK(mesh.triangles.size() == 12 * n * n);
        CHECK(volume(mesh) == doctest::Approx(8.0).epsilon(1e-14));
        const Box box = bounds(mesh);
        CHECK(box.min == glm::dvec3(-1));
        CHECK(box.max == glm::dvec3(1));
    }
}

TEST_CASE("icospheres converge to the sphere from inside, four times nearer with each subdivision") {
    const double exact = 4.0 / 3.0 * pi * 8.0;
    double previous = 1.0;
    for (uint32_t k = 1; k < 6; ++k) {
        const TriangleMesh mesh = icosphere(k, 2.0);
        check_solid(mesh, 1, 2);
        CHECK(mesh.triangles.size() == 20u << (2 * k));
        for (const glm::dvec3& p : mesh.positions) CHECK(length(p) == doctest::Approx(2.0).epsilon(1e-15));
        const double error = 1.0 - volume(mesh) / exact;
        CHECK(error > 0.0);
        if (k > 1) CHECK(previous / error == doctest::Approx(4.0).epsilon(0.1));
        previous = error;
    }
}

TEST_CASE("the torus has the volume of its polyhedron") {
    // A horizontal section is a regular n-gon minus another, each of area n/2 sin(2 pi / n) r^2. Integrated over the
    // height, that is n sin(2 pi / n) times the first moment of the minor polygon.
    for (const auto& [n, m] : {std::pair{3u, 3u}, {8u, 5u}, {96u, 48u}}) {
        const TriangleMesh mesh = torus(n, m, 1.0, 0.4);
        check_solid(mesh, 1, 0);
        const double polygon_area = 0.5 * m * std::sin(2 * pi / m) * 0.16;
        const double expected = n * std::sin(2 * pi / n) * polygon_area * 1.0;
        CHECK(volume(mesh) == doctest::Approx(expected).epsilon(1e-12));
    }
    CHECK(volume(torus(400, 400)) == doctest::Approx(2 * pi * pi * 0.16).epsilon(1e-3));
}

TEST_CASE("the torus knot has the volume of a tube along its curve") {
    const TriangleMesh mesh = torus_knot(2, 3, 4000, 48, 0.25);
    check_solid(mesh, 1, 0);
    double length_of_curve = 0.0;
    constexpr int steps = 100'000;
    for (int i = 0; i < steps; ++i) {
        const double v = 3.0 * 2.0 * pi * (i + 0.5) / steps;
        const double major_speed = 2.0 * (1.0 + 0.5 * std::cos(v));
        length_of_curve += std::hypot(major_speed, 3.0 * 0.5) * 2.0 * pi / steps;
    }
    const double polygon_area = 0.5 * 48 * std::sin(2 * pi / 48) * 0.0625;
    CHECK(volume(mesh) == doctest::Approx(polygon_area * length_of_curve).epsilon(1e-4));
    CHECK(torus_knot(4, 6).positions == torus_knot(2, 3).positions);
    check_solid(torus_knot(), 1, 0);
    check_solid(torus_knot(3, 5, 600, 12, 0.1), 1, 0);
}

TEST_CASE("the hollow sphere is two shells whose volumes subtract") {
    const TriangleMesh mesh = hollow_sphere(3, 1.0, 0.6);
    check_solid(mesh, 2, 4);
    const double shell = volume(icosphere(3, 1.0));
    CHECK(volume(mesh) == doctest::Approx(shell * (1.0 - 0.216)).epsilon(1e-13));
}

TEST_CASE("the statue is one solid with one handle that stands on its plinth") {
    double previous = 0.0;
    for (const uint32_t resolution : {40u, 64u, 90u}) {
        CAPTURE(resolution);
        const TriangleMesh mesh = statue(resolution);
        check_solid(mesh, 1, 0); // the handle is the arm whose hand is at the belt
        const Box box = bounds(mesh);
        CHECK(box.min.y == 0.0);
        CHECK(box.size().y == doctest::Approx(2.0).epsilon(0.01));
        if (previous > 0.0) CHECK(volume(mesh) == doctest::Approx(previous).epsilon(0.01));
        previous = volume(mesh);
        // The statue stands stably: its centre of mass is above the plinth.
        const MassProperties mass = mass_properties(mesh.positions, mesh.triangles);
        CHECK(std::hypot(mass.centre_of_mass.x, mass.centre_of_mass.z) < 0.1);
    }
    CHECK(statue(0).triangles.size() == statue(40).triangles.size());
    CHECK(shape("statue:48")->positions.size() < shape("statue")->positions.size());
}

TEST_CASE("the animal is one smooth solid of genus 0 on four legs") {
    double previous = 0.0;
    for (const uint32_t resolution : {56u, 64u, 97u}) {
        CAPTURE(resolution);
        const TriangleMesh mesh = four_legged_animal(resolution);
        check_solid(mesh, 1, 2);
        const Box box = bounds(mesh);
        CHECK(box.min.y == 0.0);
        CHECK(box.size().z > box.size().x);
        CHECK(volume(mesh) > 0.4);
        if (previous > 0.0) CHECK(volume(mesh) == doctest::Approx(previous).epsilon(0.01));
        previous = volume(mesh);

        // Left and right halves have equal mass, and no triangle is folded over.
        const MassProperties mass = mass_properties(mesh.positions, mesh.triangles);
        CHECK(std::abs(mass.centre_of_mass.x) < 1e-3);
        CHECK(count_folded_corners(mesh) == 0);

        std::vector<Triangle> below_the_knees;
        for (const Triangle& t : mesh.triangles) {
            const double top = std::max({mesh.positions[t.x].y, mesh.positions[t.y].y, mesh.positions[t.z].y});
            if (top < 0.35) below_the_knees.push_back(t);
        }
        CHECK(check_topology(mesh.positions.size(), below_the_knees).components == 4);
    }
    const size_t triangles = four_legged_animal().triangles.size();
    CHECK((triangles > 10'000 && triangles < 35'000));
}

TEST_CASE("every listed name gives a solid, any other name nothing") {
    for (const std::string_view name : shape_names()) {
        CAPTURE(name);
        const auto mesh = shape(name);
        REQUIRE(mesh.has_value());
        CHECK(check_topology(mesh->positions.size(), mesh->triangles).manifold());
        CHECK(volume(*mesh) > 0.0);
    }
    for (const char* bad : {"torus:", "torus:x", "torus:12 ", "torus:-3", "cube:3", ":3", "torus:99999999999"})
        CHECK_FALSE(shape(bad).has_value());
    CHECK(shape("torus:64")->positions.size() == 64 * 32);
    CHECK(shape("torus_knot:160")->positions.size() == 160 * 10);
    CHECK(shape("icosphere:2")->triangles.size() == 20 * 16);
    CHECK(shape("lattice_cube:3")->triangles.size() == 6 * 9 * 2);
    CHECK(shape("menger_sponge:0")->positions.size() == 8);
    CHECK(shape("animal:32")->positions.size() < shape("animal")->positions.size());
    CHECK_FALSE(shape("").has_value());
    CHECK_FALSE(shape("Cube").has_value());
}
