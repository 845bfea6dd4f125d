#include "fracture/mesh/topology.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "fracture/base/random.h"

using namespace brittle::fracture;

namespace {

const std::vector<Triangle> tetrahedron = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

std::vector<Triangle> operator+(std::vector<Triangle> a, const std::vector<Triangle>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

std::vector<Triangle> shifted(std::vector<Triangle> mesh, uint32_t by) {
    for (Triangle& t : mesh) t += Triangle(by);
    return mesh;
}

// An n x m grid on a torus: closed, manifold, Euler characteristic 0.
std::vector<Triangle> torus_grid(uint32_t n, uint32_t m) {
    std::vector<Triangle> mesh;
    for (uint32_t i = 0; i < n; ++i) {
        for (uint32_t j = 0; j < m; ++j) {
            const uint32_t a = i * m + j, b = (i + 1) % n * m + j;
            const uint32_t c = (i + 1) % n * m + (j + 1) % m, d = i * m + (j + 1) % m;
            mesh.push_back({a, b, c});
            mesh.push_back({a, c, d});
        }
    }
    return mesh;
}

// Two fans of n triangles between a ring and two poles: the poles have degree n.
std::vector<Triangle> bipyramid(uint32_t n) {
    std::vector<Triangle> mesh;
    for (uint32_t i = 0; i < n; ++i) {
        mesh.push_back({i, (i + 1) % n, n});
        mesh.push_back({(i + 1) % n, i, n + 1});
    }
    return mesh;
}

struct NaiveEdges {
    uint64_t edges = 0, open = 0, misoriented = 0, non_manifold = 0;
};

// The definitions of the header, implemented literally over a map.
NaiveEdges naive_edges(const std::vector<Triangle>& mesh) {
    std::map<std::pair<uint32_t, uint32_t>, std::pair<int, int>> uses;
    for (const Triangle& t : mesh) {
        if (t.x == t.y || t.y == t.z || t.z == t.x) continue;
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = t[k], b = t[(k + 1) % 3];
            auto& use = uses[{std::min(a, b), std::max(a, b)}];
            ++(a < b ? use.first : use.second);
        }
    }
    NaiveEdges n;
    for (const auto& [edge, use] : uses) {
        const int total = use.first + use.second;
        ++n.edges;
        n.open += total == 1;
        n.misoriented += total == 2 && use.first != use.second;
        n.non_manifold += total > 2;
    }
    return n;
}

} // namespace

TEST_CASE("an empty mesh is closed and has no faults") {
    const TopologyReport report = check_topology(0, {});
    CHECK(report.manifold());
    CHECK(report.vertices == 0);
    CHECK(report.components == 0);
    CHECK(describe(report).empty());
}

TEST_CASE("vertices that no triangle uses do not count") {
    const TopologyReport report = check_topology(100, shifted(tetrahedron, 50));
    CHECK(report.vertices == 4);
    CHECK(report.components == 1);
    CHECK(report.manifold());
}

TEST_CASE("a single triangle has three open edges and one fan per vertex") {
    const std::vector<Triangle> mesh = {{4, 7, 5}};
    const TopologyReport report = check_topology(8, mesh);
    CHECK(report.open_edges == 3);
    CHECK(report.first_open_edge == glm::uvec2(4, 5));
    CHECK(report.non_manifold_vertices == 0);
    CHECK_FALSE(report.closed());
    CHECK(describe(report) == "3 open edges, the first between vertices 4 and 5");
}

TEST_CASE("a triangle that names a vertex twice is degenerate and does not affect edges") {
    const TopologyReport report = check_topology(4, tetrahedron + std::vector<Triangle>{{0, 0, 1}, {2, 2, 2}});
    CHECK(report.degenerate_triangles == 2);
    CHECK(report.first_degenerate_triangle == 4u);
    CHECK(report.edges == 6);
    CHECK(report.open_edges == 0);
    CHECK_FALSE(report.closed());
    CHECK(describe(report) == "2 triangles that name a vertex twice, the first is triangle 4");
}

TEST_CASE("a flipped triangle makes its three edges misoriented") {
    std::vector<Triangle> mesh = tetrahedron;
    std::swap(mesh[2].x, mesh[2].y);
    const TopologyReport report = check_topology(4, mesh);
    CHECK(report.misoriented_edges == 3);
    CHECK(report.first_misoriented_edge == glm::uvec2(1, 2));
    CHECK(report.open_edges == 0);
    CHECK(report.non_manifold_vertices == 0);
    CHECK_FALSE(report.closed());
}

TEST_CASE("an edge shared by two closed solids is non-manifold although its uses balance") {
    // The second tetrahedron shares vertices 0 and 1 with the first.
    std::vector<Triangle> second = tetrahedron;
    for (Triangle& t : second) {
        for (int k = 0; k < 3; ++k) t[k] = t[k] < 2 ? t[k] : t[k] + 2;
    }
    const TopologyReport report = check_topology(6, tetrahedron + second);
    CHECK(report.non_manifold_edges == 1);
    CHECK(report.first_non_manifold_edge == glm::uvec2(0, 1));
    CHECK(report.edges == 11);
    CHECK_FALSE(report.closed());
}

TEST_CASE("two solids that share one vertex are closed but not manifold") {
    const TopologyReport report = check_topology(7, tetrahedron + shifted(tetrahedron, 3));
    CHECK(report.closed());
    CHECK_FALSE(report.manifold());
    CHECK(report.non_manifold_vertices == 1);
    CHECK(report.first_non_manifold_vertex == 3u);
    CHECK(report.components == 1);
    CHECK(describe(report) == "1 vertex where separate parts of the surface touch, the first is vertex 3");
}

TEST_CASE("the same solid twice on the same vertices is non-manifold everywhere") {
    const TopologyReport report = check_topology(4, tetrahedron + tetrahedron);
    CHECK(report.non_manifold_edges == 6);
    CHECK(report.edges == 6);
}

TEST_CASE("two triangles back to back are closed") {
    const std::vector<Triangle> mesh = {{0, 1, 2}, {0, 2, 1}};
    const TopologyReport report = check_topology(3, mesh);
    CHECK(report.manifold());
    CHECK(report.euler_characteristic() == 2);
}

TEST_CASE("Euler characteristics are 2 for a tetrahedron, 0 for a torus and add up over components") {
    CHECK(check_topology(4, tetrahedron).euler_characteristic() == 2);
    const std::vector<Triangle> torus = torus_grid(7, 5);
    CHECK(check_topology(35, torus).euler_characteristic() == 0);
    const TopologyReport both = check_topology(43, torus + shifted(tetrahedron, 35) + shifted(tetrahedron, 39));
    CHECK(both.manifold());
    CHECK(both.euler_characteristic() == 4);
    CHECK(both.components == 3);
}

TEST_CASE("a vertex of high degree is classified like any other") {
    for (const uint32_t n : {3u, 24u, 25u, 5000u}) {
        std::vector<Triangle> mesh = bipyramid(n);
        const TopologyReport whole = check_topology(n + 2, mesh);
        CHECK(whole.manifold());
        CHECK(whole.euler_characteristic() == 2);
        mesh.pop_back();
        const TopologyReport holed = check_topology(n + 2, mesh);
        CHECK(holed.open_edges == 3);
        CHECK(holed.non_manifold_vertices == 0);
        mesh.erase(mesh.begin() + 2 * (n / 2) + 1);
        // The gaps are opposite, so the fan of the lower pole splits in two if enough triangles remain.
        CHECK(check_topology(n + 2, mesh).non_manifold_vertices == (n > 3 ? 1 : 0));
    }
}

TEST_CASE("the description locates the first of the gravest faults and counts the others") {
    TopologyReport report;
    report.open_edges = 12;
    report.first_open_edge = glm::uvec2(4, 7);
    report.misoriented_edges = 3;
    report.degenerate_triangles = 1;
    CHECK(describe(report)
          == "12 open edges, the first between vertices 4 and 7; also 3 edges whose two triangles face "
             "opposite "
             "ways and 1 triangle that names a vertex twice");
}

TEST_CASE("components are numbered by their first triangle") {
    const std::vector<Triangle> mesh = {{9, 8, 7}, {0, 1, 2}, {7, 6, 5}, {2, 3, 4}, {10, 10, 11}};
    CHECK(triangle_components(12, mesh) == std::vector<uint32_t>{0, 1, 0, 1, 2});
    CHECK(check_topology(12, mesh).components == 3);
    CHECK(triangle_components(12, {}).empty());
}

TEST_CASE("counts on random triangle soups equal those of the literal definitions") {
    Random random(7);
    for (int round = 0; round < 200; ++round) {
        const auto vertices = static_cast<uint32_t>(3 + random.next() % 40);
        std::vector<Triangle> mesh(random.next() % 120);
        for (Triangle& t : mesh) {
            for (int k = 0; k < 3; ++k) t[k] = static_cast<uint32_t>(random.next() % vertices);
        }
        const TopologyReport report = check_topology(vertices, mesh);
        const NaiveEdges naive = naive_edges(mesh);
        CHECK(report.edges == naive.edges);
        CHECK(report.open_edges == naive.open);
        CHECK(report.misoriented_edges == naive.misoriented);
        CHECK(report.non_manifold_edges == naive.non_manifold);
        const std::vector<uint32_t> components = triangle_components(vertices, mesh);
        const uint64_t count = components.empty() ? 0 : *std::max_element(components.begin(), components.end()) + 1;
        CHECK(report.components == count);
    }
}

TEST_CASE("the report does not depend on the order of triangles") {
    Random random(11);
    std::vector<Triangle> mesh = torus_grid(20, 30);
    mesh.resize(mesh.size() - 5);
    std::swap(mesh[100].x, mesh[100].y);
    const TopologyReport before = check_topology(600, mesh);
    for (size_t i = mesh.size(); i > 1; --i) std::swap(mesh[i - 1], mesh[random.next() % i]);
    const TopologyReport after = check_topology(600, mesh);
    CHECK(before.open_edges == after.open_edges);
    CHECK(before.first_open_edge == after.first_open_edge);
    CHECK(before.misoriented_edges == after.misoriented_edges);
    CHECK(before.first_misoriented_edge == after.first_misoriented_edge);
    CHECK(before.non_manifold_vertices == after.non_manifold_vertices);
}
