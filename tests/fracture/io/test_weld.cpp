#include "fracture/io/weld.h"

#include <cmath>

#include <doctest/doctest.h>

#include "fracture/base/random.h"
#include "tests/fracture/mesh_checks.h"

using namespace brittle::fracture;

TEST_CASE("welding an empty mesh gives an empty mesh") {
    const TriangleMesh welded = weld({});
    CHECK(welded.positions.empty());
    CHECK(welded.triangles.empty());
}

TEST_CASE("welding drops degenerate triangles and unused vertices") {
    const TriangleMesh mesh{{{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {5, 5, 5}},
                            {{1, 2, 3}, {1, 2, 4}, {5, 5, 1}}};
    const TriangleMesh welded = weld(mesh);
    CHECK(welded.positions == std::vector<glm::dvec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    CHECK(welded.triangles == std::vector<Triangle>{{0, 1, 2}});
}

TEST_CASE("minus zero welds with zero, and the smallest difference does not weld") {
    const double next = std::nextafter(1.0, 2.0);
    const TriangleMesh mesh{{{0.0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.0, 0, 0}, {next, 0, 0}}, {{0, 1, 2}, {3, 2, 4}}};
    const TriangleMesh welded = weld(mesh);
    CHECK(welded.positions.size() == 4);
    CHECK(welded.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}});
}

TEST_CASE("coordinates swapped between axes do not weld") {
    const TriangleMesh mesh{{{1, 2, 3}, {2, 3, 1}, {3, 1, 2}, {3, 2, 1}, {1, 3, 2}, {2, 1, 3}}, {{0, 1, 2}, {3, 4, 5}}};
    CHECK(weld(mesh).positions.size() == 6);
}

TEST_CASE("a soup of separate triangles welds back to the mesh it was made from") {
    // A fan over random points: all vertices differ, and each is used many times.
    Random random(7);
    const Box box{glm::dvec3(-1.0), glm::dvec3(1.0)};
    TriangleMesh mesh;
    for (int k = 0; k < 2000; ++k) mesh.positions.push_back(random.uniform_in(box));
    for (uint32_t k = 0; k + 2 < 2000; ++k) mesh.triangles.emplace_back(k, k + 1, k + 2);

    TriangleMesh soup;
    for (const Triangle& t : mesh.triangles) {
        const auto base = static_cast<uint32_t>(soup.positions.size());
        for (int k = 0; k < 3; ++k) soup.positions.push_back(mesh.positions[t[k]]);
        soup.triangles.emplace_back(base, base + 1, base + 2);
    }
    const TriangleMesh welded = weld(soup);
    CHECK(welded.positions == mesh.positions);
    CHECK(welded.triangles == mesh.triangles);
}
