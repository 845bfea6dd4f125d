#include "fracture/mesh/nearest.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/mesh/triangle_tree.h"
#include "fracture/shapes/shapes.h"

using namespace brittle;
using namespace brittle::fracture;

TEST_CASE("nearest_on() returns the nearest surface point, and the point itself for an empty mesh") {
    CHECK(nearest_on({}, glm::dvec3(2.0)) == glm::dvec3(2.0));
    const TriangleMesh block = cube(2.0);
    CHECK(glm::distance(nearest_on(block, {5.0, 0.3, 0.2}), {1.0, 0.3, 0.2}) < 1e-12);
    CHECK(glm::distance(nearest_on(block, {5.0, 7.0, 0.2}), {1.0, 1.0, 0.2}) < 1e-12);
    CHECK(glm::distance(nearest_on(block, {5.0, 7.0, -9.0}), {1.0, 1.0, -1.0}) < 1e-12);
    CHECK(glm::distance(nearest_on(block, {0.9, 0.1, 0.0}), {1.0, 0.1, 0.0}) < 1e-12);
}

TEST_CASE("TriangleTree: the distance of a point agrees with a search through all triangles") {
    for (const char* name : {"icosphere", "statue", "cube"}) {
        CAPTURE(name);
        const TriangleMesh mesh = *shape(name);
        std::vector<uint32_t> all(mesh.triangles.size());
        std::iota(all.begin(), all.end(), 0u);
        const TriangleTree tree(mesh, all);
        Box box = bounds(mesh);
        const glm::dvec3 size = box.size();
        box = {box.min - 0.5 * size, box.max + 0.5 * size};
        Random random(7);
        for (int i = 0; i < 100; ++i) {
            const glm::dvec3 p = random.uniform_in(box);
            CHECK(tree.distance(p) == doctest::Approx(glm::distance(p, nearest_on(mesh, p))));
        }
        CHECK(tree.distance(mesh.positions[0]) == 0.0);
    }
    CHECK(std::isinf(TriangleTree(cube(1.0), {}).distance({0.0, 0.0, 0.0})));
}

TEST_CASE("nearest_on_triangle() agrees with a fine sampling of the triangle") {
    Random random(5);
    const Box box{{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}};
    for (int i = 0; i < 200; ++i) {
        const glm::dvec3 p = random.uniform_in(box), a = random.uniform_in(box), b = random.uniform_in(box);
        const glm::dvec3 c =
            i % 4 == 0 ? a + 0.4 * (b - a) : random.uniform_in(box); // every fourth triangle has no area
        const double least = glm::distance(p, nearest_on_triangle(p, a, b, c));
        constexpr int n = 50;
        double sampled = 10.0;
        for (int u = 0; u <= n; ++u)
            for (int v = 0; v + u <= n; ++v)
                sampled = std::min(sampled, glm::distance(p, a + (b - a) * (static_cast<double>(u) / n)
                                                                 + (c - a) * (static_cast<double>(v) / n)));
        CHECK(least <= sampled + 1e-12);
        CHECK(least >= sampled - 3.5 / n); // no side is longer than 3.5 m
    }
}

TEST_CASE("distance_to_hull() is the distance to a box, and zero inside it") {
    const std::vector<glm::vec3> one{{3.0f, 4.0f, 0.0f}}, twice(5, glm::vec3(3.0f, 4.0f, 0.0f));
    CHECK(distance_to_hull(one, glm::dvec3(0.0)) == doctest::Approx(5.0));
    CHECK(distance_to_hull(twice, glm::dvec3(0.0)) == doctest::Approx(5.0));
    Random random(9);
    const Box box{{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}};
    for (const bool flake : {false, true})
        for (int i = 0; i < 300; ++i) {
            const glm::dvec3 half(0.5, flake ? 1e-3 : 0.3, 0.8);
            std::vector<glm::vec3> corners;
            for (int c = 0; c < 8; ++c)
                corners.push_back(glm::vec3(half) * glm::vec3(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1));
            for (int k = 0; k < 24; ++k) // interior points
                corners.push_back(glm::vec3(random.uniform_in(box) * half));
            const glm::dvec3 p = 1.5 * random.uniform_in(box);
            const double expected = glm::length(glm::max(glm::abs(p) - half, glm::dvec3(0.0)));
            // The relative error is 1e-3 of the distance, or of the farthest point's distance, which is at most 2.3 m.
            CHECK(distance_to_hull(corners, p) == doctest::Approx(expected).epsilon(1.1e-3).scale(2.3));
            CHECK(distance_to_hull(corners, p) >= expected * (1.0 - 1e-6) - 1e-6);
        }
}
