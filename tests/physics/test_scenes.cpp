// The scenes of tools/bench/scenes.h, and the oracles that judge them.
#include "tools/bench/scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/base/random.h"
#include "tests/physics/bodies.h"
#include "tools/bench/overlap.h"
#include "tools/bench/theory.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::tools;

namespace {

double deepest(const Scene& scene) {
    std::vector<HullFeatures> hulls;
    std::vector<Pose> poses;
    for (const BodyDesc& body : scene.bodies) {
        hulls.push_back(features_of(body.hull));
        poses.push_back(body.pose);
    }
    double most = 0.0;
    for (const double depth : overlaps(hulls, poses)) most = std::max(most, depth);
    return most;
}

} // namespace

TEST_CASE("overlap: cubes at known distances, and none for bodies that are apart") {
    const HullFeatures cube = features_of(test_bodies::box_hull(glm::vec3(0.5f)));
    const auto depth = [&](const glm::vec3& at, const glm::quat& turn) { return overlap(cube, {}, cube, {at, turn}); };
    const glm::quat level(1.0f, 0.0f, 0.0f, 0.0f);
    CHECK(depth({0.0f, 0.0f, 0.0f}, level) == doctest::Approx(1.0).epsilon(1e-4));
    CHECK(depth({0.9f, 0.2f, 0.0f}, level) == doctest::Approx(0.1).epsilon(1e-3));
    CHECK(depth({0.2f, 0.0f, -1.25f}, level) == doctest::Approx(-0.25).epsilon(1e-3));
    CHECK(depth({5.0f, 5.0f, 5.0f}, level) < -3.9);
    // An edge upwards: its middle is half a diagonal above the centre, less what the margin rounds off.
    const glm::quat on_edge = glm::angleAxis(std::numbers::pi_v<float> / 4.0f, glm::vec3(0.0f, 0.0f, 1.0f));
    const double reach = 0.5 + (std::sqrt(0.5) - cube.margin * (std::sqrt(2.0) - 1.0));
    CHECK(depth({0.0f, 1.1f, 0.0f}, on_edge) == doctest::Approx(reach - 1.1).epsilon(1e-3));
    // Two edges that cross: no face separates them.
    const glm::quat crossed = glm::angleAxis(std::numbers::pi_v<float> / 2.0f, glm::vec3(0.0f, 1.0f, 0.0f)) * on_edge;
    const double both = 2.0 * (reach - 0.5);
    CHECK(overlap(cube, {{}, on_edge}, cube, {{0.0f, 1.3f, 0.0f}, crossed})
          == doctest::Approx(both - 1.3).epsilon(1e-3));
}

TEST_CASE("overlap: the same from either side, and along a shift by the depth the hulls part"
          * doctest::test_suite("long")) {
    fracture::Random random(3);
    const Scene heap = convex_pile();
    for (size_t i = 0; i < 40; ++i) {
        const HullFeatures a = features_of(heap.bodies[i].hull), b = features_of(heap.bodies[i + 1].hull);
        const glm::dvec3 away = random.uniform_in({glm::dvec3(-1.0), glm::dvec3(1.0)});
        const Pose pose_b{glm::vec3(0.6 * away / glm::length(away)), {1.0f, 0.0f, 0.0f, 0.0f}};
        const double depth = overlap(a, {}, b, pose_b);
        CHECK(depth == doctest::Approx(overlap(b, pose_b, a, {})).epsilon(1e-9));
        // No direction parts two hulls within less than the depth of their overlap.
        if (depth <= 0.0) continue;
        for (int k = 0; k < 20; ++k) {
            const glm::dvec3 way = glm::normalize(random.uniform_in({glm::dvec3(-1.0), glm::dvec3(1.0)}));
            const Pose moved{pose_b.position + glm::vec3(0.98 * depth * way), pose_b.orientation};
            CHECK(overlap(a, {}, b, moved) > 0.0);
        }
    }
}

TEST_CASE("overlap: the share of a body that lies inside another one") {
    const HullFeatures large = features_of(test_bodies::box_hull(glm::vec3(0.5f)));
    const HullFeatures small = features_of(test_bodies::box_hull(glm::vec3(0.1f)));
    const auto share = [&](float away) {
        const std::vector<HullFeatures> hulls{large, small};
        const std::vector<Pose> poses{{}, {{away, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f, 0.0f}}};
        const std::vector<double> shares = shares_inside(hulls, poses);
        CHECK(shares[0] == 0.0); // the larger one lies in none
        return shares[1];
    };
    CHECK(share(0.2f) == 1.0);
    CHECK(share(0.5f) == doctest::Approx(0.5).epsilon(0.3));
    CHECK(share(0.601f) == 0.0);
    CHECK(share(3.0f) == 0.0);
}

TEST_CASE("theory: the thinnest arch is that of Milankovitch, and thinner with few stones") {
    CHECK(min_arch_thickness(301) == doctest::Approx(0.1075).epsilon(0.002));
    double thinner = 0.0;
    for (const int stones : {5, 9, 15, 31, 101}) {
        CHECK(min_arch_thickness(stones) > thinner);
        thinner = min_arch_thickness(stones);
    }
    CHECK(thinner < 0.1075);
}

TEST_CASE("theory: friction slows a wave of dominoes, and the wave scales with the root of their size") {
    Dominoes row;
    double faster = 10.0;
    for (const double friction : {0.0, 0.2, 0.4}) {
        row.friction = friction;
        const double speed = domino_wave_speed(row);
        CHECK(speed > 0.5);
        CHECK(speed < faster);
        faster = speed;
    }
    Dominoes large = row;
    for (double* length : {&large.height, &large.width, &large.thickness, &large.gap}) *length *= 4.0;
    CHECK(domino_wave_speed(large) == doctest::Approx(2.0 * domino_wave_speed(row)).epsilon(0.01));
}

TEST_CASE("scenes: a world takes every body, and no two overlap at the start" * doctest::test_suite("long")) {
    const double close = 1e-5; // m: positions have single precision
    for (const Scene& scene : {stack(1, 1.0), stack(20, 0.1), loaded_stack(5, 1.0, 100.0), card_house(1), card_house(4),
                               arch(0.07), arch(0.2, 31), pyramid(10, 0.5), slope(0.3, 0.3),
                               drop(Dropped::ball, 0.5, true, 1.0), dominoes({}), dzhanibekov()}) {
        World world(scene.settings);
        CHECK(world.add_bodies(scene.bodies).has_value());
        CHECK(deepest(scene) < close);
    }
    CHECK(pyramid(50, 0.5).bodies.size() == 1275);
    CHECK(convex_pile().bodies.size() == 5120);
    CHECK(junkyard().bodies.size() == 10584 + 4 + 1);
    CHECK(many_pyramids().bodies.size() == 10780);
}

TEST_CASE("scenes: masses are those of the solids") {
    CHECK(static_cast<double>(stack(1, 0.5).bodies[0].mass) == doctest::Approx(stone_density * 0.125).epsilon(1e-5));
    const Scene loaded = loaded_stack(5, 1.0, 100.0);
    CHECK(loaded.bodies[5].mass == doctest::Approx(100.0f * loaded.bodies[0].mass));
    double sum = 0.0;
    for (const BodyDesc& body : arch(0.2, 15).bodies)
        if (!body.fixed) sum += static_cast<double>(body.mass);
    CHECK(sum
          == doctest::Approx(15 * 0.5 * 0.2 * std::sin(std::numbers::pi / 15.0) * stone_density)
                 .epsilon(2e-4)); // hulls are rounded
}
