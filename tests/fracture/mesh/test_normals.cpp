#include "fracture/mesh/normals.h"

#include <algorithm>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/shapes/shapes.h"

using namespace brittle::fracture;

TEST_CASE("a triangle without area has no normal") {
    const glm::dvec3 p(1, 2, 3), q(4, 5, 6);
    CHECK(face_normal(p, p, p) == glm::dvec3(0));
    CHECK(face_normal(p, q, p) == glm::dvec3(0));
    CHECK(face_normal({0, 0, 0}, {1, 0, 0}, {2, 0, 0}) == glm::dvec3(0));
}

TEST_CASE("vertices without faces or with faces of no area have no normal") {
    const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {5, 5, 5}}, {{0, 1, 2}}};
    for (const glm::dvec3& n : vertex_normals(mesh)) CHECK(n == glm::dvec3(0));
    CHECK(vertex_normals({}).empty());
}

TEST_CASE("counter-clockwise triangles face the viewer, at any scale") {
    for (const double s : {1e-200, 1e-9, 1.0, 1e9, 1e200}) {
        CAPTURE(s);
        CHECK(face_normal({0, 0, 0}, {s, 0, 0}, {0, s, 0}) == glm::dvec3(0, 0, 1));
        CHECK(face_normal({0, 0, 0}, {0, s, 0}, {s, 0, 0}) == glm::dvec3(0, 0, -1));
    }
}

TEST_CASE("a cube's corner normals point along its diagonals however its faces are cut") {
    // The plain mean of eq. 2 would lean towards faces that meet the corner with two triangles.
    const TriangleMesh mesh = cube();
    const std::vector<glm::dvec3> normals = vertex_normals(mesh);
    for (size_t i = 0; i < normals.size(); ++i) {
        CHECK(length(normals[i] - normalize(mesh.positions[i])) < 1e-15);
    }
}

TEST_CASE("normals of an icosphere converge to the radius") {
    double previous = 0.03;
    for (uint32_t k = 2; k < 6; ++k) {
        const TriangleMesh mesh = icosphere(k);
        const std::vector<glm::dvec3> normals = vertex_normals(mesh);
        double worst = 0.0;
        for (size_t i = 0; i < normals.size(); ++i) worst = std::max(worst, length(normals[i] - mesh.positions[i]));
        CHECK(worst < 0.51 * previous);
        previous = worst;
    }
}

TEST_CASE("a cavity's normals point into the cavity, away from the solid") {
    const TriangleMesh mesh = hollow_sphere(3);
    const std::vector<glm::dvec3> normals = vertex_normals(mesh);
    for (size_t i = 0; i < normals.size(); ++i) {
        const bool outer = length(mesh.positions[i]) > 0.8;
        CHECK((dot(normals[i], mesh.positions[i]) > 0.0) == outer);
    }
}
