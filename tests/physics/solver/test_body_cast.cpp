#include "physics/solver/body_cast.h"

#include <vector>

#include <doctest/doctest.h>

#include "tests/physics/bodies.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

std::shared_ptr<const CollisionHull> cube_hull(double half) {
    std::vector<glm::dvec3> corners;
    for (const double x : {-half, half})
        for (const double y : {-half, half})
            for (const double z : {-half, half}) corners.emplace_back(x, y, z);
    return std::make_shared<const CollisionHull>(collision_hull(corners, glm::dvec3(0.0)));
}

BodyId add_cube(World& world, float half, const glm::vec3& at, const glm::vec3& velocity) {
    BodyDesc desc{.hull = *cube_hull(static_cast<double>(half))};
    desc.pose.position = at;
    desc.linear_velocity = velocity;
    return must_add(world, desc);
}

// Cubes of 0.2 m at z = 0, 1, 2 ..
BodyId add_row(World& world, int count, bool fixed) {
    BodyDesc desc{.fixed = fixed};
    for (int i = 0; i < count; ++i)
        desc.parts.push_back({cube_hull(0.1), glm::vec3(0.0f, 0.0f, static_cast<float>(i))});
    return must_add(world, desc);
}

} // namespace

TEST_CASE("cast: a body at rest, one that flies away and one of several hulls meet nothing") {
    World world(empty_space);
    const BodyId row = add_row(world, 3, true), free_row = add_row(world, 3, false);
    CHECK(world.cast(add_cube(world, 0.1f, {0.0f, 0.0f, -1.0f}, {}), row, 1.0f).empty());
    CHECK(world.cast(add_cube(world, 0.1f, {0.0f, 0.0f, -1.0f}, {0.0f, 0.0f, -5.0f}), row, 1.0f).empty());
    CHECK(world.cast(free_row, row, 1.0f).empty());
    CHECK(world.cast(add_cube(world, 0.1f, {0.0f, 0.0f, -1.0f}, {0.0f, 0.0f, 5.0f}), row, 0.0f).empty());
}

TEST_CASE("cast: every hull on the way is met in order, at its own time, and none beside the way") {
    World world(empty_space);
    for (const bool fixed : {false, true}) {
        const BodyId row = add_row(world, 4, fixed);
        const BodyId cube = add_cube(world, 0.1f, {0.1f, 0.0f, -1.0f}, {0.0f, 0.0f, 2.0f});
        const std::vector<CastHit> hits = world.cast(cube, row, 1.5f); // 3 m: from -1 to 2
        REQUIRE(hits.size() == 3);
        for (uint32_t i = 0; i < 3; ++i) {
            CHECK(hits[i].part == i);
            CHECK(hits[i].seconds == doctest::Approx((0.8 + i) / 2.0).epsilon(0.02));
            CHECK(hits[i].direction.z == doctest::Approx(1.0));
            CHECK(hits[i].point.x == doctest::Approx(0.05).epsilon(0.05)); // the middle of 0 .. 0.1
            CHECK(std::abs(hits[i].point.y) < 1e-3f);
        }
        CHECK(world.cast(add_cube(world, 0.1f, {0.3f, 0.0f, -1.0f}, {0.0f, 0.0f, 2.0f}), row, 1.5f).empty());
    }
}
