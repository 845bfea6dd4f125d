// Air drag against closed forms: cross sections, terminal speeds, flight, sliding and spin. Drag never reverses a
// motion.
#include "physics/world/cross_section.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>
#include <glm/gtc/quaternion.hpp>

#include "fracture/shapes/shapes.h"
#include "physics/world/hull.h"
#include "physics/world/pieces.h"
#include "physics/world/world.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

constexpr double air = 1.2, gravity = 9.81;
constexpr double coefficient = 1.0; // of air_drag.h

WorldSettings air_without_gravity(float density = static_cast<float>(air)) {
    WorldSettings settings = empty_space;
    settings.air_density = density;
    return settings;
}

// The area of the projection of the points' convex hull along a direction (Andrew's monotone chain).
double projected_area(const std::vector<glm::dvec3>& points, const glm::dvec3& along) {
    const glm::dvec3 other = std::abs(along.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 right = glm::normalize(glm::cross(along, other)), up = glm::cross(along, right);
    std::vector<glm::dvec2> flat;
    for (const glm::dvec3& point : points) flat.emplace_back(glm::dot(point, right), glm::dot(point, up));
    std::ranges::sort(flat, {}, [](const glm::dvec2& p) { return std::pair(p.x, p.y); });
    const auto turn = [](const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
        return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    };
    const auto half_of_outline = [&](const auto& from) {
        std::vector<glm::dvec2> chain;
        for (const glm::dvec2& p : from) {
            while (chain.size() > 1 && turn(chain[chain.size() - 2], chain.back(), p) <= 0.0) chain.pop_back();
            chain.push_back(p);
        }
        return chain;
    };
    std::vector<glm::dvec2> outline = half_of_outline(flat);
    std::ranges::reverse(flat);
    for (const glm::dvec2& p : half_of_outline(flat)) outline.push_back(p);
    double area = 0.0;
    for (size_t i = 0; i < outline.size(); ++i) {
        const glm::dvec2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
        area += 0.5 * (a.x * b.y - a.y * b.x);
    }
    return area;
}

// A ball; its cross section is that of its hull.
struct Sphere {
    std::vector<glm::dvec3> points;
    BodyDesc body;
    explicit Sphere(double radius, float mass) : points(fracture::icosphere(2, radius).positions) {
        body.hull = collision_hull(points, glm::dvec3(0.0), {.max_vertices = 200});
        body.mass = mass;
        body.inertia = glm::mat3(static_cast<float>(0.4 * static_cast<double>(mass) * radius * radius));
    }
};

// The speed of fall in the middle of a step, half a step of gravity below the speed at its end.
float falls_at(const BodyDesc& desc, float seconds) {
    World world({.ground_height = std::nullopt});
    const BodyId id = must_add(world, desc);
    run(world, seconds);
    const glm::vec3 v = world.linear_velocity(id);
    CHECK(std::abs(v.x) + std::abs(v.z) < 1e-3f * std::abs(v.y));
    return -v.y - static_cast<float>(0.5 * gravity / 120.0);
}

// The sliding distance of a body that starts at `speed`, with deceleration friction * g + k v^2.
double distance_to_rest(double speed, double k, double friction) {
    return std::log1p(k * speed * speed / (friction * gravity)) / (2.0 * k);
}

} // namespace

TEST_CASE("air drag: points without volume have the cross section of the box around them") {
    CHECK(cross_section({}).mean() == 0.0f);
    CHECK(cross_section(std::array{glm::vec3(1.0f)}).mean() == 0.0f);
    CHECK(cross_section(std::array{glm::vec3(0.0f), glm::vec3(1.0f)}).mean() < 1e-6f);
    CHECK(reduced({}).sides.empty());
    const std::array square{glm::vec3(0, 0, 0), glm::vec3(2, 0, 0), glm::vec3(2, 0, 1), glm::vec3(0, 0, 1)};
    CHECK(cross_section(square).along({0, 1, 0}) == doctest::Approx(2.0));
    CHECK(cross_section(square).along({1, 0, 0}) == doctest::Approx(0.0));
    // The hull of flat points has some thickness, but hardly more cross section.
    std::vector<glm::dvec3> flake;
    for (const glm::vec3& p : square) flake.emplace_back(p);
    const CrossSection of_hull = collision_hull(flake, glm::dvec3(0.0)).section;
    CHECK(of_hull.along({0, 1, 0}) == doctest::Approx(2.0).epsilon(1e-3));
    CHECK(of_hull.along({1, 0, 0}) < 1e-3f);
    CHECK(collision_hull({}, glm::dvec3(0.0)).section.mean() > 0.0f);
}

TEST_CASE("air drag: the cross section of a rotated box is exact from any direction") {
    test::Random random(1);
    for (int turn = 0; turn < 50; ++turn) {
        const glm::dvec3 half = random.point(glm::dvec3(0.01), glm::dvec3(1.0));
        const glm::dquat frame = glm::angleAxis(random.uniform(0.0, 3.0), random.direction());
        const glm::dmat3 axes = glm::mat3_cast(frame);
        std::vector<glm::vec3> corners;
        for (const glm::vec3& point : box_hull(glm::vec3(half)).points)
            corners.push_back(glm::vec3(frame * glm::dvec3(point)));
        // The hull's points lie inside the box by its margin.
        glm::dvec3 inner(0.0);
        for (const glm::vec3& corner : corners)
            inner = glm::max(inner, glm::abs(glm::transpose(axes) * glm::dvec3(corner)));
        const CrossSection section = cross_section(corners);
        for (int i = 0; i < 20; ++i) {
            const glm::dvec3 u = random.direction(), own = glm::abs(glm::transpose(axes) * u);
            const double exact =
                4.0 * (inner.y * inner.z * own.x + inner.z * inner.x * own.y + inner.x * inner.y * own.z);
            CHECK(static_cast<double>(section.along(glm::vec3(u))) == doctest::Approx(exact).epsilon(1e-3).scale(0.0));
            CHECK(static_cast<double>(reduced(section.sides).along(glm::vec3(u)))
                  == doctest::Approx(exact).epsilon(1e-3).scale(0.0));
        }
    }
}

TEST_CASE("air drag: the cross section of a fracture piece is exact, and the bundled one is right on average") {
    const auto fragments = test::voronoi_pieces(glm::dvec3(-0.5), glm::dvec3(0.5), 100, 2);
    test::Random random(3);
    double worst = 0.0, rough = 0.0, mean = 0.0;
    size_t count = 0;
    for (const fracture::Piece& piece : fragments.pieces) {
        std::vector<glm::dvec3> points;
        for (const glm::dvec3& p : fragments.positions_of(piece)) points.push_back(p);
        const CrossSection section = collision_hull(points, piece.mass.centre_of_mass, {.max_vertices = 1000}).section;
        for (int i = 0; i < 100; ++i, ++count) {
            const glm::dvec3 u = random.direction();
            const double exact = projected_area(points, u);
            worst = std::max(worst, std::abs(static_cast<double>(section.along(glm::vec3(u))) / exact - 1.0));
            const double off = static_cast<double>(reduced(section.sides).along(glm::vec3(u))) / exact - 1.0;
            rough = std::max(rough, std::abs(off));
            mean += off;
        }
    }
    MESSAGE("worst ", worst, ", bundled ", rough, ", on average ", mean / static_cast<double>(count));
    CHECK(worst < 1e-5);
    CHECK(rough < 0.3);
    CHECK(std::abs(mean / static_cast<double>(count)) < 0.005);
}

TEST_CASE("air drag: a plate and a ball fall at their terminal speeds") {
    const glm::vec3 half(0.25f, 0.005f, 0.25f);
    for (const float density : {10.0f, 100.0f, 1000.0f}) {
        const float mass = density * 8.0f * half.x * half.y * half.z;
        BodyDesc plate = box(half, mass, {});
        const auto terminal = [&](double area) {
            return std::sqrt(2.0 * static_cast<double>(mass) * gravity / (air * coefficient * area));
        };
        CHECK(static_cast<double>(falls_at(plate, 60.0f)) == doctest::Approx(terminal(0.25)).epsilon(2e-3));
        plate.pose.orientation = glm::angleAxis(std::numbers::pi_v<float> / 2.0f, glm::vec3(1.0f, 0.0f, 0.0f));
        CHECK(static_cast<double>(falls_at(plate, 200.0f)) == doctest::Approx(terminal(0.005)).epsilon(2e-3));
        const Sphere ball(0.25, mass);
        const double outline = projected_area(ball.points, {0, 1, 0});
        CHECK(static_cast<double>(falls_at(ball.body, 60.0f)) == doctest::Approx(terminal(outline)).epsilon(2e-2));
        CHECK(static_cast<double>(falls_at(ball.body, 60.0f))
              == doctest::Approx(terminal(std::numbers::pi * 0.0625)).epsilon(3e-2));
    }
}

TEST_CASE("air drag: flight follows the closed form at any speed, density and step") {
    for (const float speed : {0.1f, 10.0f, 400.0f})
        for (const float density : {0.01f, 1.2f, 1000.0f})
            for (const float step : {1.0f / 120.0f, 1.0f / 30.0f}) {
                CAPTURE(speed);
                CAPTURE(density);
                CAPTURE(step);
                WorldSettings settings = air_without_gravity(density);
                settings.step = step;
                World world(settings);
                BodyDesc desc = box({0.1f, 0.2f, 0.3f}, 5.0f, {});
                desc.linear_velocity = {speed, 0.0f, 0.0f};
                const BodyId id = must_add(world, desc);
                run(world, 2.0f);
                const double k = 0.5 * static_cast<double>(density) * coefficient * 0.24 / 5.0,
                             kv = k * static_cast<double>(speed);
                CHECK(static_cast<double>(world.linear_velocity(id).x)
                      == doctest::Approx(static_cast<double>(speed) / (1.0 + kv * 2.0)).epsilon(1e-4).scale(0.0));
                CHECK(world.linear_velocity(id).y == 0.0f);
                // A step moves by the velocity at its end.
                const double behind = std::log1p(kv * 2.0) / k - static_cast<double>(world.pose(id).position.x);
                CHECK(behind > -1e-4 * static_cast<double>(speed));
                CHECK(behind < static_cast<double>(step)
                                       * (static_cast<double>(speed) - static_cast<double>(world.linear_velocity(id).x))
                                   + 1e-4 * static_cast<double>(speed));
            }
}

TEST_CASE("air drag: the cross section is taken across the direction of flight, in the body's axes") {
    // A box whose hull, inertia tensor and pose are all rotated.
    test::Random random(4);
    for (int i = 0; i < 20; ++i) {
        World world(air_without_gravity());
        const glm::vec3 half(0.05f, 0.1f, 0.4f);
        BodyDesc desc = box(half, 1.0f, {});
        const glm::quat turn =
            glm::angleAxis(static_cast<float>(random.uniform(0.0, 3.0)), glm::vec3(random.direction()));
        const glm::mat3 axes = glm::mat3_cast(turn);
        std::vector<glm::dvec3> corners;
        for (const glm::vec3& p : desc.hull.points)
            corners.emplace_back(turn * (p / (glm::vec3(1.0f) - desc.hull.margin / half)));
        desc.hull = collision_hull(corners, glm::dvec3(0.0));
        desc.inertia = axes * desc.inertia * glm::transpose(axes);
        desc.pose.orientation =
            glm::angleAxis(static_cast<float>(random.uniform(0.0, 3.0)), glm::vec3(random.direction()));
        const glm::dvec3 way = random.direction();
        desc.linear_velocity = glm::vec3(50.0 * way);
        std::vector<glm::dvec3> in_world;
        for (const glm::dvec3& corner : corners) in_world.push_back(glm::dquat(desc.pose.orientation) * corner);
        const double k = 0.5 * air * coefficient * projected_area(in_world, way);
        const BodyId id = must_add(world, desc);
        run(world, 1.0f);
        CHECK(static_cast<double>(glm::length(world.linear_velocity(id)))
              == doctest::Approx(50.0 / (1.0 + k * 50.0)).epsilon(5e-3));
        CHECK(glm::length(glm::cross(world.linear_velocity(id), glm::vec3(way))) < 1e-4f);
    }
}

TEST_CASE("air drag: spin about a principal axis decays by the closed form") {
    const glm::vec3 half(0.1f, 0.15f, 0.2f);
    const glm::dvec3 area = 4.0 * glm::dvec3(half.y * half.z, half.z * half.x, half.x * half.y);
    for (int axis = 0; axis < 3; ++axis) {
        CAPTURE(axis);
        World world(air_without_gravity(100.0f));
        BodyDesc desc = box(half, 4.0f, {});
        desc.angular_velocity[axis] = 40.0f;
        const BodyId id = must_add(world, desc);
        run(world, 1.0f);
        const double area_across = 2.0 / std::numbers::pi * (area[(axis + 1) % 3] + area[(axis + 2) % 3]);
        const double gyration = std::sqrt(static_cast<double>(desc.inertia[axis][axis]) / 4.0);
        const double k = 0.5 * 100.0 * coefficient * area_across * gyration / 4.0;
        CHECK(static_cast<double>(world.angular_velocity(id)[axis])
              == doctest::Approx(40.0 / (1.0 + k * 40.0)).epsilon(1e-3));
        CHECK(glm::length(world.linear_velocity(id)) == 0.0f);
    }
}

TEST_CASE("air drag: no motion is reversed in air of any density, and energy never rises") {
    test::Random random(5);
    for (const float step : {1.0f / 120.0f, 0.1f})
        for (const float density : {1.2f, 1e6f}) {
            WorldSettings settings = air_without_gravity(density);
            settings.step = step;
            World world(settings);
            std::vector<BodyId> leaves;
            std::vector<glm::vec3> ways;
            for (int i = 0; i < 20; ++i) {
                BodyDesc leaf = box({0.05f, 0.0003f, 0.08f}, 1e-3f, {0.0f, static_cast<float>(i) * 10.0f, 0.0f});
                leaf.pose.orientation =
                    glm::angleAxis(static_cast<float>(random.uniform(0.0, 3.0)), glm::vec3(random.direction()));
                leaf.linear_velocity = glm::vec3(400.0 * random.direction());
                leaf.linear_velocity.y = 0.0f; // each at a height of its own
                leaf.angular_velocity = glm::vec3(1000.0 * random.direction());
                leaves.push_back(must_add(world, leaf));
                ways.push_back(glm::normalize(leaf.linear_velocity));
            }
            double energy = world.mechanics().kinetic;
            for (int taken = 0; taken < 100; ++taken) {
                world.step();
                CHECK(all_finite(world));
                const double now = world.mechanics().kinetic;
                CHECK(now < energy * (1.0 + 1e-6));
                energy = now;
                for (size_t i = 0; i < leaves.size(); ++i) {
                    const glm::vec3 v = world.linear_velocity(leaves[i]);
                    CHECK(glm::dot(v, ways[i]) >= 0.0f);
                    CHECK(glm::length(v - glm::dot(v, ways[i]) * ways[i]) <= 1e-5f * glm::length(v));
                }
            }
        }
}

TEST_CASE("air drag: a sliding shard stops where friction and drag say") {
    const glm::vec3 half(0.15f, 0.01f, 0.1f);
    const double friction = 0.6 * 0.6, speed = 30.0;
    for (const float density : {0.0f, 1.2f, 12.0f}) {
        CAPTURE(density);
        World world({.air_density = density});
        BodyDesc shard = box(half, 0.6f, {0.0f, half.y, 0.0f});
        shard.linear_velocity.x = static_cast<float>(speed);
        const BodyId id = must_add(world, shard);
        run(world, 12.0f);
        REQUIRE_FALSE(world.awake(id));
        const double k = 0.5 * static_cast<double>(density) * coefficient * 4.0 * 0.01 * 0.1 / 0.6;
        const double way =
            density > 0.0f ? distance_to_rest(speed, k, friction) : speed * speed / (2.0 * friction * gravity);
        CHECK(static_cast<double>(world.pose(id).position.x) == doctest::Approx(way).epsilon(0.02));
    }
}

TEST_CASE(
    "air drag: a compound has the cross section of its bounding box or the sum over its hulls, whichever is smaller") {
    const auto slowed = [](const BodyDesc& desc, const glm::vec3& way) {
        World world(air_without_gravity());
        const BodyId id = must_add(world, desc);
        world.set_velocity(id, 100.0f * way, {});
        run(world, 1.0f);
        return 100.0f / glm::length(world.linear_velocity(id)) - 1.0f; // k v t
    };
    // Eight cubes side by side: air does not reach the faces between them.
    const BodyDesc whole = box({0.4f, 0.05f, 0.05f}, 3.0f, {});
    BodyDesc row = whole;
    const auto cube = std::make_shared<const CollisionHull>(box_hull(glm::vec3(0.05f)));
    for (int i = 0; i < 8; ++i) row.parts.push_back({cube, {0.1f * static_cast<float>(i) - 0.35f, 0.0f, 0.0f}});
    // Two cubes far apart: the box around them is nearly empty.
    BodyDesc dumbbell = whole;
    for (const float x : {-0.35f, 0.35f}) dumbbell.parts.push_back({cube, {x, 0.0f, 0.0f}});
    for (const glm::vec3 way : {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0.6f, 0.8f)}) {
        CHECK(slowed(row, way) == doctest::Approx(slowed(whole, way)).epsilon(5e-3));
        const double two = 2.0 * 0.5 * air * coefficient * 0.01
                           * static_cast<double>(std::abs(way.x) + std::abs(way.y) + std::abs(way.z)) / 3.0 * 100.0;
        CHECK(static_cast<double>(slowed(dumbbell, way)) == doctest::Approx(two).epsilon(5e-3));
    }
    // A hull without a known cross section has that of its points, which lie inside by the margin.
    BodyDesc unknown = whole;
    unknown.hull.section = {};
    const float known = slowed(whole, {0, 1, 0}), found = slowed(unknown, {0, 1, 0});
    CHECK(found < known);
    CHECK(found > 0.94f * known);
}

TEST_CASE("air drag: thrown pieces of one cut lose energy and keep their direction") {
    const auto fragments = test::voronoi_pieces(glm::dvec3(-0.25), glm::dvec3(0.25), 60, 5);
    World world({.gravity = glm::vec3(0.0f), .ground_height = std::nullopt});
    const auto bodies = add_pieces(world, fragments, {.density = 700.0f}, {.linear_velocity = {60.0f, 0.0f, 0.0f}});
    REQUIRE(bodies.has_value());
    double energy = world.mechanics().kinetic;
    for (int step = 0; step < 120; ++step) {
        world.step();
        const double now = world.mechanics().kinetic;
        CHECK(now < energy * (1.0 + 1e-6));
        energy = now;
    }
    CHECK(world.mechanics().momentum.x > 0.0);
}

TEST_CASE("air drag: a world that is cleared with new settings equals a new one") {
    const WorldSettings vacuum{.ground_height = std::nullopt, .air_density = 0.0f};
    const auto fall = [](World& world) {
        must_add(world, box({0.5f, 0.01f, 0.5f}, 1.0f, {}));
        run(world, 1.0f);
        return world.state_hash();
    };
    World in_air, fresh(vacuum);
    const uint64_t hash = fall(in_air);
    in_air.clear(vacuum);
    CHECK(in_air.settings().air_density == 0.0f);
    CHECK(fall(in_air) == fall(fresh));
    CHECK(in_air.state_hash() != hash);
}
