#include "fracture/rough/warp.h"

#include <cmath>
#include <limits>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "fracture/base/random.h"

using namespace brittle::fracture;
using namespace brittle::fracture::rough;

namespace {

const Box box{glm::dvec3(-3.0), glm::dvec3(3.0)};

// The matrix of partial derivatives, by central differences.
glm::dmat3 derivative(const Warp& warp, const glm::dvec3& p) {
    constexpr double h = 1e-6;
    glm::dmat3 columns;
    for (int k = 0; k < 3; ++k) {
        glm::dvec3 step(0.0);
        step[k] = h;
        columns[k] = (warp.apply(p + step) - warp.apply(p - step)) / (2.0 * h);
    }
    return columns;
}

} // namespace

TEST_CASE("warp: without roughness it is the identity, and bad points stay harmless") {
    const Warp flat(Roughness{}, 1.0);
    CHECK(flat.apply(glm::dvec3(1.0, 2.0, 3.0)) == glm::dvec3(1.0, 2.0, 3.0));
    CHECK(flat.reach() == 0.0);
    const Warp rough(Roughness{.amount = 1.0}, 1.0);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(std::isnan(rough.apply(glm::dvec3(nan, 0.0, 0.0)).x));
    for (const double far : {1e17, -1e17, 1e50, -1e50})
        CHECK(rough.apply(glm::dvec3(far, 0.0, 0.0)) == glm::dvec3(far, 0.0, 0.0));
}

TEST_CASE("warp: the inverse leads back, and the displacement is within reach") {
    Random random(1);
    for (const double amount : {0.1, 0.5, 1.0}) {
        for (const glm::dvec3& grain : {glm::dvec3(0.0), glm::dvec3(0.0, 4.0, 0.0), glm::dvec3(0.2, 0.1, 0.0)}) {
            const Roughness roughness{.amount = amount, .grain = grain, .detail = 3, .seed = random.next()};
            const Warp warp(roughness, 0.7);
            const double stretch = std::max(glm::length(grain), 1.0);
            for (int k = 0; k < 300; ++k) {
                const glm::dvec3 x = random.uniform_in(box), y = warp.apply(x);
                CHECK(glm::distance(x, y) <= warp.reach());
                CHECK(glm::distance(warp.inverse(y), x) < 0.01 * 0.7 * stretch);
            }
        }
    }
}

TEST_CASE("warp: one octave changes directions by less than the bound, so it is one to one") {
    Random random(2);
    double steepest = 0.0;
    for (int round = 0; round < 20; ++round) {
        const Warp warp(Roughness{.amount = 1.0, .detail = 1, .seed = random.next()}, 1.0);
        for (int k = 0; k < 500; ++k) {
            const glm::dmat3 j = derivative(warp, random.uniform_in(box));
            CHECK(glm::determinant(j) > 0.0);
            // The Lipschitz constant bounds the image of every unit vector.
            glm::dvec3 u = random.uniform_in(box);
            u = glm::normalize(u);
            steepest = std::max(steepest, glm::length(j * u - u));
        }
    }
    CHECK(steepest < 0.9);
    CHECK(steepest > 0.3); // rough
}

TEST_CASE("warp: the grain stretches displacements along itself") {
    Random random(3);
    const Warp warp(Roughness{.amount = 1.0, .grain = {0.0, 8.0, 0.0}}, 1.0);
    glm::dvec3 sum(0.0);
    for (int k = 0; k < 2000; ++k) {
        const glm::dvec3 x = random.uniform_in(box);
        sum += glm::abs(warp.apply(x) - x);
    }
    CHECK(sum.y > 6.0 * sum.x);
    CHECK(sum.y > 6.0 * sum.z);
    CHECK(sum.y < 11.0 * sum.x);
}

TEST_CASE("warp: nothing moves in a calm ball, everything does beyond its fade, and the warp stays one to one") {
    Random random(4);
    const Roughness roughness{.amount = 1.0, .detail = 1};
    const std::vector<CalmBall> calm{{glm::dvec3(0.5), 0.4}, {glm::dvec3(0.9, 0.5, 0.5), 0.2}};
    const Warp warp(roughness, 1.0), whole(roughness, 1.0);
    const Warp calmed(roughness, 1.0, calm);
    const Box around{glm::dvec3(-2.0), glm::dvec3(3.0)};
    for (int k = 0; k < 3000; ++k) {
        const glm::dvec3 x = random.uniform_in(around);
        const double near = std::min(glm::distance(x, calm[0].centre) - calm[0].radius,
                                     glm::distance(x, calm[1].centre) - calm[1].radius);
        if (near <= 0.0) CHECK(calmed.apply(x) == x);
        if (near >= fade_wavelengths) CHECK(calmed.apply(x) == whole.apply(x));
        CHECK(glm::determinant(derivative(calmed, x)) > 0.0);
    }
}

TEST_CASE("warp: equal seeds give equal bits, other seeds another warp, and many points the same as one") {
    const Roughness roughness{.amount = 0.6, .detail = 2, .seed = 9};
    const Warp a(roughness, 0.3), b(roughness, 0.3), c(Roughness{.amount = 0.6, .detail = 2, .seed = 10}, 0.3);
    Random random(5);
    std::vector<glm::dvec3> points;
    for (int k = 0; k < 100; ++k) points.push_back(random.uniform_in(box));
    // Compares all points at once by one warp with each by an equal warp. Returns how many a third warp moves alike.
    const auto moved_alike = [&](const Warp& all, const Warp& each, const Warp& other) {
        std::vector<glm::dvec3> images(points), back(points);
        all.apply(images);
        all.inverse(back);
        int alike = 0;
        for (size_t k = 0; k < points.size(); ++k) {
            CHECK(images[k] == each.apply(points[k]));
            CHECK(back[k] == each.inverse(points[k]));
            alike += images[k] == other.apply(points[k]) ? 1 : 0;
        }
        return alike;
    };
    CHECK(moved_alike(a, b, c) == 0);
    // Balls beside some of the points only.
    const Warp calmed(roughness, 0.3, std::vector<CalmBall>{{points[0], 0.1}, {points[1], 0.05}, {points[2], 0.3}});
    const int alike = moved_alike(calmed, calmed, a);
    CHECK(alike > 0);
    CHECK(alike < 100);
}
