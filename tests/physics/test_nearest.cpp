#include "physics/nearest.h"

#include <algorithm>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/random.h"
#include "fracture/shapes.h"

using namespace brittle;
using namespace brittle::physics;

TEST_CASE("the nearest point of a surface is on it") {
    CHECK(nearest_on({}, glm::dvec3(2.0)) == glm::dvec3(2.0));
    const fracture::TriangleMesh cube = fracture::cube(2.0);
    CHECK(glm::distance(nearest_on(cube, {5.0, 0.3, 0.2}), {1.0, 0.3, 0.2}) < 1e-12);
    CHECK(glm::distance(nearest_on(cube, {5.0, 7.0, 0.2}), {1.0, 1.0, 0.2}) < 1e-12);
    CHECK(glm::distance(nearest_on(cube, {5.0, 7.0, -9.0}), {1.0, 1.0, -1.0}) < 1e-12);
    CHECK(glm::distance(nearest_on(cube, {0.9, 0.1, 0.0}), {1.0, 0.1, 0.0}) < 1e-12);
}

TEST_CASE("no sample of a triangle is nearer than its nearest point, and one is about as near") {
    fracture::Random random(5);
    const fracture::Box box{{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}};
    for (int i = 0; i < 200; ++i) {
        const glm::dvec3 p = random.uniform_in(box), a = random.uniform_in(box), b = random.uniform_in(box);
        const glm::dvec3 c = i % 4 == 0 ? a + 0.4 * (b - a) : random.uniform_in(box); // some are flat
        const double least = glm::distance(p, nearest_on_triangle(p, a, b, c));
        constexpr int n = 50;
        double sampled = 10.0;
        for (int u = 0; u <= n; ++u)
            for (int v = 0; v + u <= n; ++v)
                sampled = std::min(sampled, glm::distance(p, a + (b - a) * (static_cast<double>(u) / n)
                                                                 + (c - a) * (static_cast<double>(v) / n)));
        CHECK(least <= sampled + 1e-12);
        CHECK(least >= sampled - 3.5 / n); // the sides are below 3.5 m
    }
}
