#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

#include "fracture/base/random.h"
#include "fracture/mesh/half_edge.h"
#include "fracture/mesh/topology.h"
#include "fracture/shapes/shapes.h"

using namespace brittle::fracture;

namespace {

HalfEdgeMesh isolated_vertices(uint32_t count) {
    HalfEdgeMesh mesh;
    for (uint32_t i = 0; i < count; ++i) add_vertex(mesh, {i, 0.0, 0.0});
    return mesh;
}

AddFace add(HalfEdgeMesh& mesh, uint32_t a, uint32_t b, uint32_t c) {
    return add_face(mesh, {a, b, c}, {});
}

std::vector<size_t> loop_lengths(const HalfEdgeMesh& mesh) {
    std::vector<size_t> lengths;
    for (const auto& loop : border_loops(mesh)) lengths.push_back(loop.size());
    std::sort(lengths.begin(), lengths.end());
    return lengths;
}

// A Fisher-Yates shuffle with Brittle's own random numbers, so that a failure repeats on every machine.
template<class T>
void shuffle(std::vector<T>& items, Random& random) {
    for (size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[random.next() % i]);
}

const std::vector<Triangle> tetrahedron{{0, 1, 2}, {1, 0, 3}, {2, 1, 3}, {0, 2, 3}};

// Two tetrahedra that share vertex 0 only.
TriangleMesh tetrahedra_at_one_vertex() {
    TriangleMesh mesh;
    mesh.positions.resize(7, glm::dvec3(0.0));
    mesh.triangles = tetrahedron;
    for (const Triangle& t : tetrahedron) {
        Triangle moved = t;
        for (int i = 0; i < 3; ++i)
            if (moved[i] != 0) moved[i] += 3;
        mesh.triangles.push_back(moved);
    }
    return mesh;
}

} // namespace

TEST_CASE("a half-edge mesh without faces is valid and closed") {
    CHECK(is_valid(HalfEdgeMesh{}));
    CHECK(is_closed(HalfEdgeMesh{}));
    CHECK(is_valid(isolated_vertices(3)));
    CHECK(find_half_edge(isolated_vertices(3), 0, 1) == no_index);
}

TEST_CASE("a single triangle has a border of three half-edges around it") {
    HalfEdgeMesh mesh = isolated_vertices(3);
    REQUIRE(add(mesh, 0, 1, 2) == AddFace::added);
    CHECK(is_valid(mesh));
    CHECK_FALSE(is_closed(mesh));
    REQUIRE(loop_lengths(mesh) == std::vector<size_t>{3});
    // The border runs in the opposite direction: 0, 2, 1.
    const uint32_t border = find_half_edge(mesh, 0, 2);
    CHECK(mesh.is_border(border));
    CHECK(mesh[mesh[border].next].origin == 2);
    CHECK(mesh.target(mesh[border].next) == 1);
}

TEST_CASE("a face against one border half-edge is spliced into the chain") {
    HalfEdgeMesh mesh = isolated_vertices(4);
    REQUIRE(add(mesh, 0, 1, 2) == AddFace::added);
    REQUIRE(add(mesh, 2, 1, 3) == AddFace::added);
    CHECK(is_valid(mesh));
    CHECK(loop_lengths(mesh) == std::vector<size_t>{4});
}

TEST_CASE("two borders that meet in a vertex become one chain, and triangles between them shorten it") {
    HalfEdgeMesh mesh = isolated_vertices(5);
    REQUIRE(add(mesh, 0, 1, 2) == AddFace::added);
    REQUIRE(add(mesh, 0, 3, 4) == AddFace::added);
    CHECK(is_valid(mesh));
    CHECK(loop_lengths(mesh) == std::vector<size_t>{6});
    REQUIRE(add(mesh, 0, 2, 3) == AddFace::added);
    CHECK(is_valid(mesh));
    CHECK(loop_lengths(mesh) == std::vector<size_t>{5});
    REQUIRE(add(mesh, 0, 4, 1) == AddFace::added);
    CHECK(is_valid(mesh));
    CHECK(loop_lengths(mesh) == std::vector<size_t>{4});
}

TEST_CASE("three fans around a vertex can be joined in either order") {
    for (const bool clockwise : {false, true}) {
        HalfEdgeMesh mesh = isolated_vertices(7);
        REQUIRE(add(mesh, 0, 1, 2) == AddFace::added);
        REQUIRE(add(mesh, 0, 3, 4) == AddFace::added);
        REQUIRE(add(mesh, 0, 5, 6) == AddFace::added);
        REQUIRE(is_valid(mesh));
        if (clockwise) {
            REQUIRE(add(mesh, 0, 6, 3) == AddFace::added);
            REQUIRE(is_valid(mesh));
            REQUIRE(add(mesh, 0, 4, 1) == AddFace::added);
        } else {
            REQUIRE(add(mesh, 0, 4, 1) == AddFace::added);
            REQUIRE(is_valid(mesh));
            REQUIRE(add(mesh, 0, 2, 5) == AddFace::added);
        }
        CHECK(is_valid(mesh));
        CHECK(loop_lengths(mesh) == std::vector<size_t>{7});
    }
}

TEST_CASE("faces that do not fit are refused and leave the mesh unchanged") {
    HalfEdgeMesh mesh = isolated_vertices(7);
    for (const Triangle& t : tetrahedron) REQUIRE(add_face(mesh, t, {}) == AddFace::added);
    REQUIRE(is_closed(mesh));
    CHECK(add(mesh, 4, 4, 5) == AddFace::repeated_vertex);
    CHECK(add(mesh, 0, 1, 4) == AddFace::taken_edge);
    CHECK(add(mesh, 0, 4, 5) == AddFace::taken_vertex);
    CHECK(is_valid(mesh));
    CHECK(is_closed(mesh));
    CHECK(triangle_list(mesh) == tetrahedron);
}

TEST_CASE("closing one fan of a vertex that has another open fan is refused") {
    HalfEdgeMesh mesh = isolated_vertices(6);
    REQUIRE(add(mesh, 0, 1, 2) == AddFace::added);
    REQUIRE(add(mesh, 0, 2, 3) == AddFace::added);
    REQUIRE(add(mesh, 0, 4, 5) == AddFace::added);
    CHECK(add(mesh, 0, 3, 1) == AddFace::taken_vertex);
    CHECK(is_valid(mesh));
    CHECK(mesh.faces.size() == 3);
}

TEST_CASE("an error of build_half_edges() names the faulty triangle") {
    const std::vector<glm::dvec3> positions(4, glm::dvec3(0.0));
    const auto message = [&](std::vector<Triangle> triangles) {
        const Result<HalfEdgeMesh> mesh = build_half_edges(positions, triangles);
        REQUIRE_FALSE(mesh);
        CHECK(mesh.error().status == Status::invalid_mesh);
        return mesh.error().message;
    };
    CHECK(message({{0, 1, 2}, {1, 0, 9}}).find("triangle 1 names vertex 9") != std::string::npos);
    CHECK(message({{0, 1, 2}, {3, 3, 1}}).find("triangle 1 (vertices 3, 3, 1)") != std::string::npos);
    CHECK(message({{0, 1, 2}, {0, 1, 3}}).find("same direction") != std::string::npos);
    CHECK(message({{0, 1, 2}, {1, 0, 3}, {0, 1, 3}}).find("triangle 2") != std::string::npos);
}

TEST_CASE("the triangles of a shape are returned in order") {
    for (const std::string_view name : shape_names()) {
        CAPTURE(name);
        const TriangleMesh mesh = *shape(name);
        const Result<HalfEdgeMesh> built = build_half_edges(mesh.positions, mesh.triangles);
        REQUIRE(built);
        CHECK(is_valid(*built));
        CHECK(is_closed(*built));
        CHECK(triangle_list(*built) == mesh.triangles);
    }
}

TEST_CASE("faces may be added in any order, and the border is valid after each") {
    const TriangleMesh mesh = icosphere(1);
    Random random(7);
    for (int round = 0; round < 40; ++round) {
        std::vector<Triangle> triangles = mesh.triangles;
        shuffle(triangles, random);
        HalfEdgeMesh built = isolated_vertices(static_cast<uint32_t>(mesh.positions.size()));
        for (const Triangle& t : triangles) {
            REQUIRE(add_face(built, t, {}) == AddFace::added);
            REQUIRE(is_valid(built));
        }
        CHECK(is_closed(built));
    }
}

TEST_CASE("a fan of many triangles in random order is built in reasonable time") {
    constexpr uint32_t count = 30000;
    std::vector<Triangle> triangles;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t j = (i + 1) % count;
        triangles.emplace_back(0, 2 + i, 2 + j);
        triangles.emplace_back(1, 2 + j, 2 + i);
    }
    Random random(3);
    shuffle(triangles, random);
    const std::vector<glm::dvec3> positions(count + 2, glm::dvec3(0.0));
    const Result<HalfEdgeMesh> mesh = build_half_edges(positions, triangles);
    REQUIRE(mesh);
    CHECK(is_valid(*mesh));
    CHECK(is_closed(*mesh));
}

TEST_CASE("is_valid() detects damage") {
    const TriangleMesh shape = cube();
    const HalfEdgeMesh good = *build_half_edges(shape.positions, shape.triangles);
    REQUIRE(is_valid(good));
    const auto damaged = [&](auto&& damage) {
        HalfEdgeMesh mesh = good;
        damage(mesh);
        return is_valid(mesh);
    };
    CHECK_FALSE(damaged([](HalfEdgeMesh& m) { m[0].twin = m[1].twin; }));
    CHECK_FALSE(damaged([](HalfEdgeMesh& m) { m[4].next = 4; }));
    CHECK_FALSE(damaged([](HalfEdgeMesh& m) { m[3].origin = 99; }));
    CHECK_FALSE(damaged([](HalfEdgeMesh& m) { m[2].face = no_index; }));
    CHECK_FALSE(damaged([](HalfEdgeMesh& m) { m.outgoing[0] = m.outgoing[1]; }));
    CHECK_FALSE(damaged([](HalfEdgeMesh& m) { m.faces[0] = m.faces[1]; }));
    CHECK_FALSE(damaged([](HalfEdgeMesh& m) { m.sources.pop_back(); }));
}

TEST_CASE("split_fans() gives solids that touch in a vertex a vertex each") {
    const TriangleMesh touching = tetrahedra_at_one_vertex();
    const Result<HalfEdgeMesh> refused = build_half_edges(touching.positions, touching.triangles);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().message.find("triangle 4") != std::string::npos);

    const TriangleMesh split = split_fans(touching);
    CHECK(split.positions.size() == 8);
    CHECK(split.triangles.size() == touching.triangles.size());
    const Result<HalfEdgeMesh> mesh = build_half_edges(split.positions, split.triangles);
    REQUIRE(mesh);
    CHECK(is_valid(*mesh));
    CHECK(is_closed(*mesh));
}

TEST_CASE("split_fans() leaves a manifold mesh unchanged") {
    const TriangleMesh mesh = torus(12, 8);
    const TriangleMesh split = split_fans(mesh);
    CHECK(split.positions == mesh.positions);
    CHECK(split.triangles == mesh.triangles);
}
