#include <doctest/doctest.h>

#include <vector>

#include "fracture/mesh/islands.h"
#include "fracture/mesh/topology.h"
#include "fracture/sequential/clip.h"
#include "fracture/shapes/shapes.h"

using namespace brittle::fracture;

namespace {

void append(TriangleMesh& mesh, const TriangleMesh& other, const glm::dvec3& at = glm::dvec3(0.0),
            bool inside_out = false) {
    const auto offset = static_cast<uint32_t>(mesh.positions.size());
    for (const glm::dvec3& p : other.positions) mesh.positions.push_back(p + at);
    for (const Triangle& t : other.triangles)
        mesh.triangles.push_back((inside_out ? Triangle(t.x, t.z, t.y) : t) + offset);
}

std::vector<Island> islands_of(const TriangleMesh& mesh) {
    std::vector<FaceSource> sources;
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) sources.push_back({.index = i});
    return split_islands(mesh.positions, mesh.triangles, sources);
}

std::vector<Island> islands_of(const HalfEdgeMesh& mesh) {
    return split_islands(mesh.positions, triangle_list(mesh), mesh.sources);
}

Bisector plane(const glm::dvec3& n, double d) {
    return {0, 1, n, n * (d / glm::dot(n, n))};
}

void check(const Island& island) {
    CHECK(describe(check_topology(island.positions.size(), island.triangles)) == "");
    REQUIRE(island.sources.size() == island.triangles.size());
    for (size_t i = 0; i < island.sources.size(); ++i)
        CHECK(island.sources[i].interior == (i >= island.exterior_triangles));
}

} // namespace

TEST_CASE("an empty mesh has no islands") {
    CHECK(split_islands({}, {}, {}).empty());
}

TEST_CASE("a sheet without thickness is no island") {
    TriangleMesh flat = cube();
    for (glm::dvec3& p : flat.positions) p.y = 0.3;
    CHECK(islands_of(flat).empty());
}

TEST_CASE("one solid is one island without unused vertices") {
    TriangleMesh mesh = icosphere(2);
    mesh.positions.emplace_back(100, 100, 100); // no triangle uses it
    const auto islands = islands_of(mesh);
    REQUIRE(islands.size() == 1);
    check(islands[0]);
    CHECK(islands[0].positions.size() == mesh.positions.size() - 1);
    CHECK(islands[0].triangles.size() == mesh.triangles.size());
}

TEST_CASE("solids side by side are islands in the order of their triangles") {
    TriangleMesh mesh;
    append(mesh, cube(1.0), {5, 0, 0});
    append(mesh, cube(2.0));
    const auto islands = islands_of(mesh);
    REQUIRE(islands.size() == 2);
    CHECK(islands[0].mass.volume == doctest::Approx(1.0));
    CHECK(islands[1].mass.volume == doctest::Approx(8.0));
    CHECK(islands[1].sources[0].index == 12);
}

TEST_CASE("a cavity belongs to the smallest island around it") {
    // A hollow ball in the cavity of a larger hollow ball, and a separate ball smaller than all others.
    TriangleMesh mesh;
    append(mesh, icosphere(2, 0.6), {}, true);
    append(mesh, icosphere(2, 0.1), {2, 0, 0});
    append(mesh, icosphere(2, 1.0));
    append(mesh, icosphere(2, 0.4));
    append(mesh, icosphere(2, 0.2), {}, true);
    const auto islands = islands_of(mesh);
    REQUIRE(islands.size() == 3);
    const double unit = mass_properties(icosphere(2).positions, icosphere(2).triangles).volume;
    CHECK(islands[0].mass.volume == doctest::Approx(unit * 0.001));
    CHECK(islands[1].mass.volume == doctest::Approx(unit * (1.0 - 0.216)));
    CHECK(islands[2].mass.volume == doctest::Approx(unit * (0.064 - 0.008)));
    for (const Island& island : islands) check(island);
}

TEST_CASE("an inward shell that nothing encloses is an island of its own") {
    TriangleMesh mesh;
    append(mesh, cube(), {}, true);
    const auto islands = islands_of(mesh);
    REQUIRE(islands.size() == 1);
    CHECK(islands[0].mass.volume == doctest::Approx(-8.0));
}

TEST_CASE("the winding number is one inside, zero outside and minus one in an inverted solid") {
    const TriangleMesh ring = torus(24, 12, 1.0, 0.4);
    CHECK(winding_number({1, 0, 0}, ring.positions, ring.triangles) == doctest::Approx(1.0));
    CHECK(winding_number({0, 0, 0}, ring.positions, ring.triangles) == doctest::Approx(0.0));
    CHECK(winding_number({3, 1, 0}, ring.positions, ring.triangles) == doctest::Approx(0.0));
    TriangleMesh inverted;
    append(inverted, ring, {}, true);
    CHECK(winding_number({1, 0, 0}, inverted.positions, inverted.triangles) == doctest::Approx(-1.0));
}

TEST_CASE("the legs of an animal below a plane are four pieces") {
    const TriangleMesh animal = four_legged_animal();
    const Box box = bounds(animal);
    const double knee = box.min.y + 0.1 * box.size().y;
    const HalfEdgeMesh whole = *build_half_edges(animal.positions, animal.triangles);
    const auto legs = islands_of(clip(whole, plane({0, 1, 0}, knee), 0));
    CHECK(legs.size() == 4);
    for (const Island& leg : legs) {
        check(leg);
        CHECK(leg.exterior_triangles > 0);
        CHECK(leg.exterior_triangles < leg.triangles.size());
    }
    CHECK(islands_of(clip(whole, plane({0, 1, 0}, knee), 1)).size() == 1);
}

TEST_CASE("a hollow sphere cut beside its cavity keeps the cavity in one piece") {
    const TriangleMesh ball = hollow_sphere(3, 1.0, 0.5);
    const HalfEdgeMesh whole = *build_half_edges(ball.positions, ball.triangles);
    const auto with_cavity = islands_of(clip(whole, plane({0, 1, 0}, 0.7), 0));
    REQUIRE(with_cavity.size() == 1);
    check(with_cavity[0]);
    CHECK(check_topology(with_cavity[0].positions.size(), with_cavity[0].triangles).components == 2);
    const auto lid = islands_of(clip(whole, plane({0, 1, 0}, 0.7), 1));
    REQUIRE(lid.size() == 1);
    const double total = mass_properties(ball.positions, ball.triangles).volume;
    CHECK(with_cavity[0].mass.volume + lid[0].mass.volume == doctest::Approx(total).epsilon(1e-12));
}
