#include "fracture/repair.h"

#include <doctest/doctest.h>

#include "mesh_checks.h"

using namespace brittle::fracture;
using test::is_closed;

namespace {

// A cube of edge 2 around the origin; vertex x y z in binary, 0 for -1.
TriangleMesh plain_cube() {
    TriangleMesh mesh;
    for (int v = 0; v < 8; ++v) mesh.positions.emplace_back(v & 4 ? 1 : -1, v & 2 ? 1 : -1, v & 1 ? 1 : -1);
    mesh.triangles = {{4, 6, 7}, {4, 7, 5}, {0, 1, 3}, {0, 3, 2}, {2, 3, 7}, {2, 7, 6},
                      {0, 4, 5}, {0, 5, 1}, {1, 5, 7}, {1, 7, 3}, {0, 2, 6}, {0, 6, 4}};
    return mesh;
}

} // namespace

TEST_CASE("a mesh without spare patches comes back as it is") {
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

TEST_CASE("of a quad split along both diagonals the later pair of triangles goes") {
    TriangleMesh mesh = plain_cube();
    const std::vector<Triangle> cube = mesh.triangles;
    mesh.triangles.insert(mesh.triangles.end(), {{5, 4, 6}, {5, 6, 7}});
    REQUIRE(!is_closed(mesh.triangles));
    const Repair repair = remove_spare_patches(mesh);
    CHECK(repair.removed_patches == 1);
    CHECK(repair.removed_triangles == 2);
    CHECK(repair.mesh.triangles == cube);
}

TEST_CASE("a misoriented spare pair goes even where it comes first") {
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

TEST_CASE("an inner wall goes: without it the surface around is closed") {
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
