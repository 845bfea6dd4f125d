#include "physics/bonds/rewound_contacts.h"

#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

BodyId add_cube(World& world, float mass, const glm::vec3& at, const glm::vec3& velocity, bool fixed = false) {
    std::vector<glm::dvec3> corners;
    for (const double x : {-0.5, 0.5})
        for (const double y : {-0.5, 0.5})
            for (const double z : {-0.5, 0.5}) corners.emplace_back(x, y, z);
    BodyDesc desc{.hull = collision_hull(corners, glm::dvec3(0.0)), .fixed = fixed, .mass = mass};
    desc.inertia = glm::mat3(mass / 6.0f);
    desc.pose.position = at;
    desc.linear_velocity = velocity;
    return must_add(world, desc);
}

} // namespace

TEST_CASE("rewound contacts: none, and contacts between fixed bodies, change nothing") {
    World world(empty_space);
    const BodyId wall = add_cube(world, 1.0f, {}, {}, true);
    std::vector<RewoundContact> contacts;
    solve_rewound(world, contacts);
    contacts.push_back({.a = wall, .normal = {0.0f, 1.0f, 0.0f}});
    solve_rewound(world, contacts);
    CHECK(contacts[0].impulse == 0.0f);
}

TEST_CASE("rewound contacts: bodies that meet end at their common speed, and those that part are left alone") {
    for (const float speed : {3.0f, -3.0f}) {
        World world(empty_space);
        const BodyId a = add_cube(world, 1.0f, {1.0f, 0.0f, 0.0f}, {}),
                     b = add_cube(world, 2.0f, {}, {speed, 0.0f, 0.0f});
        std::vector<RewoundContact> contacts{
            {.a = a, .b = b, .point = {0.5f, 0.0f, 0.0f}, .normal = {1.0f, 0.0f, 0.0f}}};
        solve_rewound(world, contacts);
        CAPTURE(speed);
        CHECK(world.linear_velocity(a).x == doctest::Approx(speed > 0.0f ? 2.0 : 0.0));
        CHECK(world.linear_velocity(b).x == doctest::Approx(speed > 0.0f ? 2.0 : -3.0));
        CHECK(contacts[0].impulse == doctest::Approx(speed > 0.0f ? 2.0 : 0.0));
    }
}

TEST_CASE("rewound contacts: a limit bounds the impulse, and a gap lets bodies approach") {
    World world(empty_space);
    const BodyId wall = add_cube(world, 1.0f, {1.0f, 0.0f, 0.0f}, {}, true),
                 a = add_cube(world, 2.0f, {}, {3.0f, 0.0f, 0.0f}), b = add_cube(world, 2.0f, {}, {3.0f, 0.0f, 0.0f});
    std::vector<RewoundContact> contacts{
        {.a = wall, .b = a, .point = {0.5f, 0.0f, 0.0f}, .normal = {1.0f, 0.0f, 0.0f}, .max_impulse = 4.0f},
        {.a = wall, .b = b, .point = {0.5f, 0.0f, 0.0f}, .normal = {1.0f, 0.0f, 0.0f}, .closing = 0.5f}};
    solve_rewound(world, contacts);
    CHECK(contacts[0].impulse == doctest::Approx(4.0));
    CHECK(world.linear_velocity(a).x == doctest::Approx(1.0));
    CHECK(contacts[1].impulse == doctest::Approx(5.0));
    CHECK(world.linear_velocity(b).x == doctest::Approx(0.5));
}

TEST_CASE("rewound contacts: random bodies keep momentum and angular momentum, and energy never rises") {
    for (uint64_t seed = 1; seed <= 50; ++seed) {
        test::Random random(seed);
        World world(empty_space);
        std::vector<BodyId> bodies;
        for (int i = 0; i < 12; ++i)
            bodies.push_back(add_cube(world, static_cast<float>(random.uniform(0.1, 50.0)),
                                      glm::vec3(random.point(glm::dvec3(-2.0), glm::dvec3(2.0))),
                                      glm::vec3(random.point(glm::dvec3(-9.0), glm::dvec3(9.0)))));
        std::vector<RewoundContact> contacts;
        for (size_t i = 0; i < 40; ++i)
            contacts.push_back({.a = bodies[i % 12],
                                .b = bodies[(5 * i + 1 + i / 12) % 12],
                                .point = glm::vec3(random.point(glm::dvec3(-2.0), glm::dvec3(2.0))),
                                .normal = glm::vec3(random.direction())});
        std::erase_if(contacts, [](const RewoundContact& contact) { return contact.a == contact.b; });
        const Mechanics before = world.mechanics();
        solve_rewound(world, contacts);
        const Mechanics after = world.mechanics();
        CAPTURE(seed);
        CHECK(glm::length(after.momentum - before.momentum) < 1e-3);
        CHECK(glm::length(after.angular_momentum - before.angular_momentum) < 1e-2);
        CHECK(after.kinetic <= before.kinetic * (1.0 + 1e-6));
    }
}
