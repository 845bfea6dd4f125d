#include "fracture/doctor/repair.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include "fracture/base/random.h"
#include "fracture/mesh/topology.h"
#include "fracture/shapes/shapes.h"
#include "tests/fracture/mesh_checks.h"
#include "tests/fracture/repair_checks.h"

using namespace brittle::fracture;
using namespace brittle::fracture::test;

TEST_CASE("a mesh without spare patches is returned unchanged") {
    CHECK(remove_spare_patches({}).mesh.triangles.empty());
    const TriangleMesh cube = plain_cube();
    REQUIRE(is_closed(cube.triangles));
    const Repair repair = remove_spare_patches(cube);
    CHECK(repair.removed_patches == 0);
    CHECK(repair.mesh.triangles == cube.triangles);
    CHECK(repair.mesh.positions == cube.positions);
}

TEST_CASE("an open mesh stays open and whole") {
    TriangleMesh mesh = plain_cube();
    mesh.triangles.resize(10);
    CHECK(remove_spare_patches(mesh).removed_triangles == 0);
}

TEST_CASE("of a quad split along both diagonals the later pair of triangles is removed") {
    TriangleMesh mesh = plain_cube();
    const std::vector<Triangle> cube = mesh.triangles;
    mesh.triangles.insert(mesh.triangles.end(), {{5, 4, 6}, {5, 6, 7}});
    REQUIRE(!is_closed(mesh.triangles));
    const Repair repair = remove_spare_patches(mesh);
    CHECK(repair.removed_patches == 1);
    CHECK(repair.removed_triangles == 2);
    CHECK(repair.mesh.triangles == cube);
}

TEST_CASE("a misoriented spare pair is removed even where it comes first") {
    TriangleMesh mesh = plain_cube();
    const std::vector<Triangle> cube = mesh.triangles;
    mesh.triangles.insert(mesh.triangles.begin(), {{5, 6, 4}, {5, 6, 7}});
    const Repair repair = remove_spare_patches(mesh);
    CHECK(repair.removed_triangles == 2);
    CHECK(repair.mesh.triangles == cube);
}

TEST_CASE("several spare patches are all removed, a doubled triangle too") {
    TriangleMesh mesh = plain_cube();
    mesh.triangles.insert(mesh.triangles.end(), {{5, 4, 6}, {5, 6, 7}, {0, 1, 2}, {2, 1, 3}, {0, 4, 5}});
    const Repair repair = remove_spare_patches(mesh);
    CHECK(repair.removed_patches == 3);
    CHECK(repair.removed_triangles == 5);
    CHECK(is_closed(repair.mesh.triangles));
    CHECK(test::signed_volume(repair.mesh) == 8.0);
}

TEST_CASE("an inner wall is removed where the surface is closed without it") {
    TriangleMesh mesh = plain_cube();
    const std::vector<Triangle> cube = mesh.triangles;
    mesh.triangles.insert(mesh.triangles.end(), {{0, 1, 7}, {0, 7, 6}});
    const Repair repair = remove_spare_patches(mesh);
    CHECK(repair.removed_patches == 1);
    CHECK(repair.mesh.triangles == cube);
}

TEST_CASE("two solids that touch along an edge both stay") {
    TriangleMesh mesh = plain_cube();
    const std::vector<Triangle> cube = mesh.triangles;
    // The second cube lies diagonally above the edge from 6 to 7 and shares these two vertices.
    const uint32_t second[8] = {6, 7, 8, 9, 10, 11, 12, 13};
    for (int v = 2; v < 8; ++v) mesh.positions.emplace_back(v & 4 ? 3 : 1, v & 2 ? 3 : 1, v & 1 ? 1 : -1);
    for (const Triangle& t : cube) mesh.triangles.emplace_back(second[t.x], second[t.y], second[t.z]);
    REQUIRE(test::signed_volume(mesh) == 16.0);
    CHECK(remove_spare_patches(mesh).removed_triangles == 0);
}

TEST_CASE("a shape without flaws is returned bit for bit") {
    for (const std::string_view name : shape_names()) {
        CAPTURE(name);
        const TriangleMesh mesh = *shape(name);
        const Repaired repaired = repair(mesh);
        CHECK(same(repaired.mesh, mesh));
        CHECK(!repaired.report.changed());
        CHECK(describe(repaired.report) == "");
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t) REQUIRE(repaired.source_triangle[t] == t);
    }
}

TEST_CASE("an unreadable mesh is returned unchanged") {
    CHECK(repair({}).mesh.triangles.empty());
    TriangleMesh mesh = plain_cube();
    mesh.triangles[3].y = 8;
    Repaired repaired = repair(mesh);
    CHECK(same(repaired.mesh, mesh));
    CHECK(repaired.report.bad_triangles.count == 1);
    CHECK(repaired.report.bad_triangles.first == 3);
    CHECK(describe(repaired.report).find("triangle 3") != std::string::npos);
    mesh = plain_cube();
    mesh.positions[5].z = std::numeric_limits<double>::quiet_NaN();
    mesh.positions[6].x = 1e60;
    repaired = repair(mesh);
    CHECK(repaired.mesh.triangles == mesh.triangles);
    CHECK(repaired.report.bad_vertices.count == 2);
    CHECK(repaired.report.bad_vertices.first == 5);
}

TEST_CASE("triangles that face the wrong way are turned") {
    for (uint64_t seed = 0; seed < 20; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        for (const TriangleMesh& whole : {icosphere(2), torus(12, 8), menger_sponge(1)}) {
            TriangleMesh mesh = whole;
            uint64_t turned = 0;
            const double part = random.uniform();
            for (Triangle& t : mesh.triangles)
                if (random.uniform() < part) {
                    turn(t);
                    ++turned;
                }
            const Repaired repaired = check_solid(mesh, test::signed_volume(whole));
            CHECK(repaired.report.turned_triangles.count == turned);
            CHECK(same(repaired.mesh, whole));
        }
    }
}

TEST_CASE("of four sheets that share an edge, the one that faces the wrong way is turned") {
    TriangleMesh cross; // the axis, then two vertices of each sheet
    for (const double z : {0.0, 1.0}) cross.positions.emplace_back(0.0, 0.0, z);
    for (const glm::dvec2 way : {glm::dvec2(1, 0), glm::dvec2(0, 1), glm::dvec2(-1, 0), glm::dvec2(0, -1)}) {
        const auto v = static_cast<uint32_t>(cross.positions.size());
        for (const double z : {0.0, 1.0}) cross.positions.emplace_back(way.x, way.y, z);
        // Neighbours around the axis bound one quarter of space, so every other sheet uses it upwards.
        if ((v - 2) / 2 % 2 == 0)
            cross.triangles.insert(cross.triangles.end(), {{0, v, v + 1}, {0, v + 1, 1}});
        else
            cross.triangles.insert(cross.triangles.end(), {{0, v + 1, v}, {0, 1, v + 1}});
    }
    const Repaired right = repair(cross, {.close_holes = 0.0});
    CHECK(right.report.turned_triangles.count == 0);
    for (size_t sheet = 0; sheet < 4; ++sheet) {
        CAPTURE(sheet);
        TriangleMesh mesh = cross;
        for (const size_t t : {2 * sheet, 2 * sheet + 1}) turn(mesh.triangles[t]);
        const Repaired repaired = repair(mesh, {.close_holes = 0.0});
        CHECK(repaired.report.turned_triangles.count >= 2);
        CHECK(repaired.mesh.triangles == right.mesh.triangles);
    }
}

TEST_CASE("a mesh that is inside out as a whole is turned") {
    TriangleMesh mesh = torus(16, 8);
    const double volume = test::signed_volume(mesh);
    for (Triangle& t : mesh.triangles) turn(t);
    CHECK(check_solid(mesh, volume).report.turned_triangles.count == mesh.triangles.size());
}

TEST_CASE("option cavities: a cavity faces inwards, a solid inside it outwards") {
    RepairSettings settings;
    settings.cavities = true;
    const TriangleMesh whole = hollow_sphere(2);
    const double volume = test::signed_volume(whole);
    const size_t half = whole.triangles.size() / 2;
    for (const int which : {1, 2, 3}) { // turn the first, the second, both
        TriangleMesh mesh = whole;
        for (size_t t = 0; t < mesh.triangles.size(); ++t)
            if (which & (t < half ? 1 : 2)) turn(mesh.triangles[t]);
        CHECK(same(check_solid(mesh, volume, settings).mesh, whole));
    }
    TriangleMesh nested = whole;
    append(nested, icosphere(2, 0.4));
    append(nested, icosphere(1, 0.1), glm::dvec3(0.05));
    append(nested, icosphere(1, 0.1), glm::dvec3(3.0, 0.0, 0.0));
    const double ball = test::signed_volume(icosphere(1, 0.1));
    check_solid(nested, volume + test::signed_volume(icosphere(2, 0.4)) - ball + ball, settings);
    CHECK(!repair(nested).report.changed());
}

TEST_CASE("option covered_parts: covered parts are dropped") {
    RepairSettings settings;
    settings.covered_parts = true;
    const TriangleMesh outer = icosphere(2, 2.0);
    TriangleMesh mesh = outer;
    append(mesh, icosphere(1, 0.5));                            // a solid in a solid
    append(mesh, icosphere(1, 0.2));                            // inside both
    append(mesh, icosphere(1, 0.3), glm::dvec3(1.2, 0.0, 0.0)); // beside both
    const Repaired solid = check_solid(mesh, test::signed_volume(outer), settings);
    CHECK(solid.mesh.triangles == outer.triangles);
    CHECK(solid.report.covered_parts.count == 3);
    CHECK(solid.report.covered_parts.first == outer.triangles.size());
    CHECK_FALSE(repair(mesh).report.changed());

    TriangleMesh hollow = hollow_sphere(2);
    append(hollow, icosphere(1, 0.3)); // a ball in the cavity is solid
    CHECK_FALSE(repair(hollow, settings).report.changed());
    TriangleMesh crossing = cube();
    append(crossing, cube(), glm::dvec3(0.5));
    append(crossing, icosphere(1, 0.1)); // inside both
    const Repaired crossed = repair(crossing, settings);
    CHECK(crossed.report.covered_parts.count == 1);
    CHECK(crossed.mesh.triangles.size() == 24);
}

TEST_CASE("duplicate triangles are dropped") {
    const TriangleMesh whole = torus(12, 8);
    const double volume = test::signed_volume(whole);
    for (uint64_t seed = 0; seed < 20; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        TriangleMesh mesh = whole;
        uint64_t doubled = 0;
        for (size_t t = 0; t < whole.triangles.size(); ++t) {
            if (random.uniform() > 0.3) continue;
            Triangle copy = whole.triangles[t];
            std::rotate(&copy[0], &copy[0] + random.next() % 3, &copy[0] + 3);
            if (random.uniform() < 0.5) turn(copy);
            const bool in_front = random.uniform() < 0.5;
            mesh.triangles.insert(in_front ? mesh.triangles.begin() : mesh.triangles.end(), copy);
            ++doubled;
        }
        const Repaired repaired = check_solid(mesh, volume);
        CHECK(repaired.report.duplicate_triangles.count == doubled);
        CHECK(repaired.mesh.triangles.size() == whole.triangles.size());
    }
    TriangleMesh both_sides = whole;
    for (Triangle t : whole.triangles) {
        turn(t);
        both_sides.triangles.push_back(t);
    }
    CHECK(check_solid(both_sides, volume).mesh.triangles.size() == whole.triangles.size());
}

TEST_CASE("a wall that two solids share is dropped") {
    // Two cubes side by side, each with its own wall between vertices 4 to 7.
    const TriangleMesh one = plain_cube();
    TriangleMesh pair = one;
    const uint32_t of_second[8] = {4, 5, 6, 7, 8, 9, 10, 11};
    for (int v = 4; v < 8; ++v) pair.positions.push_back(one.positions[static_cast<size_t>(v)] + glm::dvec3(2, 0, 0));
    for (const Triangle& t : one.triangles) pair.triangles.emplace_back(of_second[t.x], of_second[t.y], of_second[t.z]);
    REQUIRE(test::signed_volume(pair) == doctest::Approx(16.0));
    const Repaired repaired = check_solid(pair, 16.0);
    CHECK(repaired.report.duplicate_triangles.count == 4);
    CHECK(repaired.mesh.triangles.size() == 20);
}

TEST_CASE("vertices on a crack are welded") {
    for (const double apart : {0.0, 1e-9}) {
        CAPTURE(apart);
        const TriangleMesh whole = torus(24, 12);
        Random random(7);
        TriangleMesh soup; // every triangle has three vertices of its own
        for (const Triangle& t : whole.triangles) {
            for (int k = 0; k < 3; ++k)
                soup.positions.push_back(whole.positions[t[k]]
                                         + apart * (random.uniform_in({glm::dvec3(-1.0), glm::dvec3(1.0)})));
            const auto n = static_cast<uint32_t>(soup.positions.size());
            soup.triangles.emplace_back(n - 3, n - 2, n - 1);
        }
        const Repaired repaired = check_solid(soup, test::signed_volume(whole), 1e-7);
        CHECK(repaired.report.welded_vertices.count == soup.positions.size() - whole.positions.size());
        CHECK(repaired.report.closed_holes.count == 0);
        RepairSettings equal_only;
        equal_only.weld_distance = 0.0;
        const Repaired plain = repair(soup, equal_only);
        CHECK(plain.report.welded_vertices.count == (apart > 0.0 ? 0 : repaired.report.welded_vertices.count));
    }
    // Vertices on closed parts stay, however close: two spheres that touch in one vertex each.
    TriangleMesh spheres = icosphere(2);
    append(spheres, icosphere(2), spheres.positions[0] * 2.0);
    CHECK(!repair(spheres).report.changed());
}

TEST_CASE("solids that share an edge or a vertex are separated") {
    const TriangleMesh one = plain_cube();
    TriangleMesh edge = one, vertex = one;
    const uint32_t by_edge[8] = {6, 7, 8, 9, 10, 11, 12, 13}, by_vertex[8] = {7, 8, 9, 10, 11, 12, 13, 14};
    for (int v = 2; v < 8; ++v) edge.positions.emplace_back(v & 4 ? 3 : 1, v & 2 ? 3 : 1, v & 1 ? 1 : -1);
    for (int v = 1; v < 8; ++v) vertex.positions.emplace_back(v & 4 ? 3 : 1, v & 2 ? 3 : 1, v & 1 ? 3 : 1);
    for (const Triangle& t : one.triangles) {
        edge.triangles.emplace_back(by_edge[t.x], by_edge[t.y], by_edge[t.z]);
        vertex.triangles.emplace_back(by_vertex[t.x], by_vertex[t.y], by_vertex[t.z]);
    }
    for (const int which : {0, 1, 2, 3}) { // none, the first, the second, both inside out
        CAPTURE(which);
        TriangleMesh a = edge, b = vertex;
        for (size_t t = 0; t < 24; ++t)
            if (which & (t < 12 ? 1 : 2)) {
                turn(a.triangles[t]);
                turn(b.triangles[t]);
            }
        const Repaired apart = check_solid(a, 16.0);
        CHECK(check_topology(apart.mesh.positions.size(), apart.mesh.triangles).components == 2);
        CHECK(apart.mesh.positions.size() == 16);
        CHECK(apart.report.split_edges.count == 1);
        CHECK(apart.report.split_edges.first == 6);
        check_sources(a, apart, true);
        const Repaired touching = check_solid(b, 16.0);
        CHECK(touching.mesh.positions.size() == 16);
        CHECK(touching.report.split_vertices.count == 1);
        CHECK(touching.report.split_vertices.first == 7);
    }
    // Two cavities: the solid around the edge stays together, so they become one.
    TriangleMesh inverse = edge;
    for (Triangle& t : inverse.triangles) turn(t);
    TriangleMesh block = cube(10.0);
    append(block, inverse);
    const Repaired cavities = check_solid(block, 1000.0 - 16.0);
    CHECK(cavities.report.halved_edges.count == 1);
    CHECK(check_topology(cavities.mesh.positions.size(), cavities.mesh.triangles).components == 2);
}

TEST_CASE("triangles that name a vertex twice, and triangles without area") {
    TriangleMesh mesh = plain_cube();
    const TriangleMesh cube = mesh;
    mesh.triangles.insert(mesh.triangles.begin() + 5, {{3, 3, 1}, {2, 2, 2}, {7, 0, 7}});
    const Repaired repaired = check_solid(mesh, 8.0);
    CHECK(same(repaired.mesh, cube));
    CHECK(repaired.report.degenerate_triangles.count == 3);
    CHECK(repaired.report.degenerate_triangles.first == 5);
    CHECK(repaired.source_triangle[5] == 8);

    // An edge with a vertex in its middle on one side only: a triangle without area closes the crack of width zero.
    mesh = cube;
    mesh.positions.emplace_back(1.0, 0.0, 1.0); // between 5 and 7
    for (Triangle& t : mesh.triangles)
        if (t == Triangle(4, 7, 5)) t = {4, 7, 8};
    mesh.triangles.emplace_back(4, 8, 5);
    const Repaired crack = check_solid(mesh, 8.0);
    CHECK(crack.report.new_triangles == 1);
    const Repaired again = repair(crack.mesh);
    CHECK(again.report.flat_triangles.count == 1);
}

TEST_CASE("loose triangles and fins are dropped") {
    TriangleMesh mesh = plain_cube();
    const TriangleMesh cube = mesh;
    mesh.positions.insert(mesh.positions.end(), {{3, 0, 0}, {4, 0, 0}, {3, 1, 0}});
    mesh.triangles.insert(mesh.triangles.end(), {{8, 9, 10}, {6, 7, 8}});
    const Repaired repaired = check_solid(mesh, 8.0);
    CHECK(repaired.report.loose_triangles.count == 2);
    CHECK(repaired.mesh.triangles == cube.triangles);
    RepairSettings settings;
    settings.loose_triangles = false;
    const Repaired kept = repair(mesh, settings);
    check_promises(mesh, kept, settings);
    CHECK(is_manifold(kept.mesh));
    CHECK(kept.report.new_vertices.count == 2);
    CHECK(kept.report.loose_triangles.count == 0);
}

TEST_CASE("any soup of indices becomes a manifold that a second repair keeps") {
    for (uint64_t seed = 0; seed < 2000; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        TriangleMesh mesh;
        const uint64_t vertices = 3 + random.next() % 20, triangles = 1 + random.next() % 60;
        const bool on_lattice = random.uniform() < 0.5;
        for (uint64_t v = 0; v < vertices; ++v) {
            glm::dvec3 p = random.uniform_in({glm::dvec3(0.0), glm::dvec3(3.0)});
            if (on_lattice) p = glm::floor(p);
            mesh.positions.push_back(p);
        }
        for (uint64_t t = 0; t < triangles; ++t)
            mesh.triangles.emplace_back(random.next() % vertices, random.next() % vertices, random.next() % vertices);
        const Repaired repaired = repair(mesh);
        check_promises(mesh, repaired);
        CHECK(is_manifold(repaired.mesh));
    }
}

TEST_CASE("large soups take seconds at most" * doctest::test_suite("long")) {
    Random random(1);
    TriangleMesh mesh;
    for (int v = 0; v < 3000; ++v) mesh.positions.push_back(random.uniform_in({glm::dvec3(0.0), glm::dvec3(1.0)}));
    for (int t = 0; t < 20000; ++t)
        mesh.triangles.emplace_back(random.next() % 3000, random.next() % 3000, random.next() % 3000);
    const Repaired repaired = repair(mesh);
    CHECK(repaired.source_triangle.size() == repaired.mesh.triangles.size());
}
