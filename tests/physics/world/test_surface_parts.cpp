#include "physics/world/surface_parts.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/mesh/inside.h"
#include "fracture/shapes/shapes.h"
#include "physics/world/world.h"
#include "tests/physics/bodies.h"

namespace brittle::physics {

namespace {

using fracture::TriangleMesh;

BodyDesc fixed_surface(const TriangleMesh& mesh, float friction = 0.6f) {
    return {
        .parts = surface_parts(mesh.positions, mesh.triangles, glm::dvec3(0.0)), .fixed = true, .friction = friction};
}

// A heightfield of cells by cells squares with this side, m, around the origin; open, without a bottom.
template<class Height>
TriangleMesh heightfield(int cells, double side, Height height) {
    TriangleMesh mesh;
    for (int z = 0; z <= cells; ++z)
        for (int x = 0; x <= cells; ++x) {
            const double px = side * (x - 0.5 * cells), pz = side * (z - 0.5 * cells);
            mesh.positions.emplace_back(px, height(px, pz), pz);
        }
    const auto at = [&](int x, int z) { return static_cast<uint32_t>(z * (cells + 1) + x); };
    for (int z = 0; z < cells; ++z)
        for (int x = 0; x < cells; ++x) {
            mesh.triangles.emplace_back(at(x, z), at(x, z + 1), at(x + 1, z + 1));
            mesh.triangles.emplace_back(at(x, z), at(x + 1, z + 1), at(x + 1, z));
        }
    return mesh;
}

World world_without_ground() {
    return World({.ground_height = std::nullopt, .air_density = 0.0f});
}

} // namespace

TEST_CASE("surface_parts(): triangles without area give no part, and a box has six facets") {
    const std::vector<glm::dvec3> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    const std::vector<fracture::Triangle> flat{{0, 1, 2}};
    CHECK(surface_parts(line, flat, glm::dvec3(0.0)).empty());
    CHECK(surface_parts({}, {}, glm::dvec3(0.0)).empty());
    const TriangleMesh box = fracture::cuboid({1.0, 2.0, 3.0});
    CHECK(surface_parts(box.positions, box.triangles, glm::dvec3(0.0)).size() == 6);
}

TEST_CASE("surface_parts(): a slab lies inside the solid") {
    for (const TriangleMesh& mesh : {fracture::cube(), fracture::torus(), fracture::arch(), fracture::icosphere(3)}) {
        const fracture::InsideTest inside(mesh);
        for (const BodyPart& part : surface_parts(mesh.positions, mesh.triangles, glm::dvec3(0.0)))
            for (const glm::vec3& p : part.hull->points) // pulled in, because corners lie on other faces of the cube
                CHECK(inside(0.99 * glm::dvec3(p) + glm::dvec3(part.offset)));
    }
}

TEST_CASE("A fixed surface: a box slides over the seams of a plane as over one face") {
    const TriangleMesh plane = heightfield(40, 0.25, [](double, double) { return 0.0; });
    const auto slide = [](const BodyDesc& floor) {
        World world = world_without_ground();
        REQUIRE(world.add_body(floor));
        BodyDesc box = test_bodies::box(glm::vec3(0.15f), 1.0f, {-3.0f, 0.151f, 0.07f});
        box.linear_velocity = {4.0f, 0.0f, 0.0f};
        const BodyId id = *world.add_body(box);
        for (int step = 0; step < 240; ++step) {
            world.step();
            CHECK(std::abs(world.pose(id).position.y - 0.15f) < 0.002f);
        }
        return world.pose(id);
    };
    BodyDesc seams = fixed_surface(plane);
    seams.parts = surface_parts(plane.positions, plane.triangles, glm::dvec3(0.0), {.max_corners = 3});
    CHECK(seams.parts.size() == plane.triangles.size());
    CHECK(fixed_surface(plane).parts.size() <= plane.triangles.size() / 4);
    BodyDesc block = test_bodies::box({10.0f, 0.5f, 10.0f}, 1.0f, {0.0f, -0.5f, 0.0f});
    block.fixed = true;
    const Pose over_block = slide(block);
    for (const BodyDesc& floor : {seams, fixed_surface(plane)}) {
        const Pose over = slide(floor);
        CHECK(glm::length(over.position - over_block.position) < 0.01f);
        CHECK(std::abs(glm::dot(over.orientation, over_block.orientation)) > 0.9999f);
    }
}

TEST_CASE("A fixed surface: a box slides down stairs and stops on the floor below, level") {
    TriangleMesh stairs; // a profile of steps, 2 m wide, open at its ends
    for (int k = 0; k < 20; ++k)
        for (const double z : {-1.0, 1.0}) stairs.positions.emplace_back(0.3 * ((k + 1) / 2), -0.15 * (k / 2), z);
    stairs.positions[38].x = stairs.positions[39].x = 8.0; // the last tread is the floor
    for (uint32_t k = 0; k < 19; ++k) {
        const uint32_t a = 2 * k;
        stairs.triangles.emplace_back(a, a + 1, a + 3);
        stairs.triangles.emplace_back(a, a + 3, a + 2);
    }
    World world = world_without_ground();
    REQUIRE(world.add_body(fixed_surface(stairs)));
    BodyDesc box = test_bodies::box({0.35f, 0.1f, 0.2f}, 5.0f, {0.0f, 0.11f, 0.0f});
    box.linear_velocity = {2.0f, 0.0f, 0.0f};
    const BodyId id = *world.add_body(box);
    for (int step = 0; step < 1200; ++step) world.step();
    const Pose end = world.pose(id);
    CAPTURE(end.position.x);
    CHECK_FALSE(world.awake(id));
    CHECK(end.position.y == doctest::Approx(-0.15f * 9 + 0.1f).epsilon(0.01));
}

TEST_CASE("A fixed surface: balls roll to the bottom of an open bowl and rest there, side by side") {
    const TriangleMesh bowl = heightfield(40, 0.05, [](double x, double z) { return 0.5 * (x * x + z * z); });
    World world = world_without_ground();
    REQUIRE(world.add_body(fixed_surface(bowl)));
    const TriangleMesh ball = fracture::icosphere(1, 0.1);
    std::vector<BodyId> ids;
    for (int k = 0; k < 5; ++k)
        ids.push_back(*world.add_body(
            {.hull = collision_hull(ball.positions, glm::dvec3(0.0)),
             .inertia = glm::mat3(0.004f),
             .pose = {.position = {0.25f * static_cast<float>(k) - 0.5f, 0.6f, 0.1f * static_cast<float>(k)}}}));
    for (int step = 0; step < 1200; ++step) world.step();
    for (const BodyId id : ids) {
        const glm::vec3 p = world.pose(id).position;
        const float height = 0.5f * (p.x * p.x + p.z * p.z);
        CHECK_FALSE(world.awake(id));
        CHECK(p.y - height > 0.08f); // the flat of a ball of this few corners is nearer than its radius
        CHECK(p.y - height < 0.11f);
        CHECK(glm::length(p) < 0.3f);
    }
}

TEST_CASE("A fixed surface: boxes thrown on bumpy ground rest on it, and no corner is below it") {
    const auto height = [](double x, double z) {
        const double rim = std::max({std::abs(x) - 2.5, std::abs(z) - 2.5, 0.0});
        return 0.15 * std::sin(3.0 * x) * std::cos(2.5 * z) + 4.0 * rim;
    };
    const TriangleMesh ground = heightfield(80, 0.1, height);
    World world = world_without_ground();
    REQUIRE(world.add_body(fixed_surface(ground)));
    const glm::vec3 half(0.1f, 0.15f, 0.06f);
    std::vector<BodyId> ids;
    for (int k = 0; k < 60; ++k) {
        const auto f = static_cast<float>(k);
        BodyDesc box = test_bodies::box(
            half, 1.0f, {-2.0f + 0.5f * std::fmod(f, 8.0f), 1.0f + 0.4f * std::floor(f / 8.0f), -2.0f + 0.06f * f});
        box.linear_velocity = {0.0f, -20.0f, 0.0f};
        ids.push_back(*world.add_body(box));
    }
    for (int step = 0; step < 1800; ++step) world.step();
    for (const BodyId id : ids) {
        CHECK_FALSE(world.awake(id));
        const Pose pose = world.pose(id);
        for (int corner = 0; corner < 8; ++corner) {
            const glm::vec3 sign((corner & 1) != 0 ? 1.0f : -1.0f, (corner & 2) != 0 ? 1.0f : -1.0f,
                                 (corner & 4) != 0 ? 1.0f : -1.0f);
            const glm::vec3 at = pose.position + pose.orientation * (sign * half);
            // 5 mm of overlap, and 3 mm between the heightfield and its function
            CHECK(static_cast<double>(at.y) > height(static_cast<double>(at.x), static_cast<double>(at.z)) - 0.008);
        }
    }
}

} // namespace brittle::physics
