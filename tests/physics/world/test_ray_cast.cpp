// Rays against bodies and the ground, on both engines. The oracle tries all planes through three points of each hull.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/shapes/shapes.h"
#include "physics/world/joint.h"
#include "physics/world/surface_parts.h"
#include "physics/world/world.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

constexpr EngineKind engines[] = {EngineKind::solver, EngineKind::bullet};
constexpr float infinite = std::numeric_limits<float>::infinity();
constexpr double bullet_error = 0.01; // m

WorldSettings on(EngineKind engine, WorldSettings settings = empty_space) {
    settings.engine = engine;
    return settings;
}

// The planes of the convex hull of points, by brute force.
std::vector<HullPlane> planes_of(const std::vector<glm::vec3>& points) {
    std::vector<HullPlane> planes;
    double size = 0.0;
    for (const glm::vec3& p : points) size = std::max(size, glm::length(glm::dvec3(p)));
    for (size_t i = 0; i < points.size(); ++i)
        for (size_t j = i + 1; j < points.size(); ++j)
            for (size_t k = j + 1; k < points.size(); ++k) {
                const glm::dvec3 a(points[i]), b(points[j]), c(points[k]), across = glm::cross(b - a, c - a);
                if (glm::length(across) < 1e-9 * size * size) continue;
                for (const double sign : {1.0, -1.0}) {
                    const glm::dvec3 normal = sign * glm::normalize(across);
                    const auto outside = [&](const glm::vec3& p) {
                        return glm::dot(normal, glm::dvec3(p) - a) > 1e-6 * size;
                    };
                    if (std::ranges::none_of(points, outside)) planes.push_back({normal, glm::dot(normal, a)});
                }
            }
    return planes;
}

// A hull of a body where it is now.
struct Placed {
    BodyId body;
    uint32_t part;
    std::vector<HullPlane> planes; // in the world, through the points
    double margin;

    // m, beyond the planes; negative inside
    [[nodiscard]] double height(const glm::dvec3& point) const {
        double most = -1e30;
        for (const HullPlane& plane : planes) most = std::max(most, glm::dot(plane.normal, point) - plane.distance);
        return most;
    }
    // The share at which a ray enters the hull grown by a distance; a ray that begins inside enters nowhere.
    [[nodiscard]] std::optional<double> entry(const Ray& ray, double grown) const {
        const glm::dvec3 from(ray.from), along = glm::dvec3(ray.to) - from;
        if (height(from) <= grown) return std::nullopt;
        double enters = 0.0, leaves = 1.0;
        for (const HullPlane& plane : planes) {
            const double above = glm::dot(plane.normal, from) - plane.distance - grown,
                         rise = glm::dot(plane.normal, along);
            if (rise == 0.0 && above > 0.0) return std::nullopt;
            if (rise < 0.0) enters = std::max(enters, above / -rise);
            if (rise > 0.0) leaves = std::min(leaves, -above / rise);
        }
        return enters <= leaves ? std::optional(enters) : std::nullopt;
    }
};

// Bodies with what the oracle knows of them.
struct Scene {
    World world;
    std::vector<std::pair<BodyId, BodyDesc>> bodies;

    explicit Scene(const WorldSettings& settings) : world(settings) {}
    BodyId add(const BodyDesc& desc) {
        const BodyId id = must_add(world, desc);
        bodies.emplace_back(id, desc);
        return id;
    }
    [[nodiscard]] std::vector<Placed> placed() const {
        std::vector<Placed> all;
        for (const auto& [id, desc] : bodies) {
            if (!world.contains(id)) continue;
            const Pose pose = world.pose(id);
            const glm::dquat turn = glm::normalize(glm::dquat(pose.orientation));
            const auto place = [&, body = id](uint32_t part, const CollisionHull& hull, const glm::vec3& offset) {
                Placed one{body, part, planes_of(hull.points), double{hull.margin}};
                for (HullPlane& plane : one.planes) {
                    const glm::dvec3 at =
                        glm::dvec3(pose.position) + turn * (plane.normal * plane.distance + glm::dvec3(offset));
                    plane.normal = turn * plane.normal;
                    plane.distance = glm::dot(plane.normal, at);
                }
                all.push_back(one);
            };
            if (desc.parts.empty()) place(0, desc.hull, glm::vec3(0.0f));
            for (uint32_t part = 0; part < desc.parts.size(); ++part)
                place(part, *desc.parts[part].hull, desc.parts[part].offset);
        }
        return all;
    }
};

CollisionHull random_hull(test::Random& random, double size) {
    std::vector<glm::dvec3> points;
    for (int i = 0; i < 10; ++i) points.push_back(size * random.direction());
    return collision_hull(points, glm::dvec3(0.0));
}

// Boxes, hulls of ten points, compounds, debris and a fixed staircase: some fall, some lie, one hangs on a joint.
void fill(Scene& scene) {
    test::Random random(3);
    const auto spread = [&] { return glm::vec3(random.point({-2.0, 0.4, -2.0}, {2.0, 2.5, 2.0})); };
    const fracture::TriangleMesh stairs = *fracture::shape("stairs");
    scene.add({.parts = surface_parts(stairs.positions, stairs.triangles, glm::dvec3(0.0)), .fixed = true});
    for (int i = 0; i < 25; ++i) {
        BodyDesc hull{.hull = random_hull(random, i % 5 == 0 ? 0.012 : 0.2), .pose = {.position = spread()}};
        hull.angular_velocity = glm::vec3(random.point(glm::dvec3(-4.0), glm::dvec3(4.0)));
        scene.add(hull);
        BodyDesc fixed = box({0.1f, 0.05f, 0.2f}, 1.0f, spread());
        fixed.pose.orientation =
            glm::normalize(glm::quat(1.0f, glm::vec3(random.point(glm::dvec3(-1.0), glm::dvec3(1.0)))));
        fixed.fixed = i % 2 == 0;
        scene.add(fixed);
        BodyDesc slabs = in_slabs(box({0.2f, 0.03f, 0.1f}, 2.0f, spread()), {0.2f, 0.03f, 0.1f}, 4);
        slabs.linear_velocity = glm::vec3(random.point(glm::dvec3(-2.0), glm::dvec3(2.0)));
        scene.add(slabs);
    }
    const BodyId hanging = scene.add(box(glm::vec3(0.1f), 1.0f, {0.0f, 2.8f, 0.0f}));
    REQUIRE(scene.world.add_joint({.a = hanging, .anchor_a = {0.0f, 3.0f, 0.0f}}));
}

} // namespace

TEST_CASE("rays: without length, not finite, in an empty world or past everything, they meet nothing") {
    for (const EngineKind engine : engines) {
        CAPTURE(to_string(engine));
        World empty(on(engine));
        CHECK_FALSE(empty.cast_ray({{0.0f, 5.0f, 0.0f}, {0.0f, -5.0f, 0.0f}}));
        empty.cast_rays({}, {});
        World world(on(engine, {.ground_height = 0.0f}));
        must_add(world, box(glm::vec3(0.5f), 1.0f, {0.0f, 2.0f, 0.0f}));
        CHECK(world.cast_ray({{0.0f, 5.0f, 0.0f}, {0.0f, 0.0f, 0.0f}}));
        CHECK_FALSE(world.cast_ray({{0.0f, 5.0f, 0.0f}, {0.0f, 5.0f, 0.0f}})); // no length
        CHECK_FALSE(world.cast_ray({{0.0f, 2.0f, 0.0f}, {0.0f, 2.0f, 0.0f}})); // the same, inside
        CHECK_FALSE(world.cast_ray({{0.0f, 5.0f, 0.0f}, {0.0f, 2.6f, 0.0f}})); // ends before
        CHECK_FALSE(world.cast_ray({{0.0f, 5.0f, 0.0f}, {0.0f, 9.0f, 0.0f}})); // away
        CHECK_FALSE(world.cast_ray({{0.6f, 5.0f, 0.0f}, {0.6f, 0.1f, 0.0f}})); // beside
        for (const float bad : {NAN, infinite, -infinite})
            for (int axis = 0; axis < 3; ++axis) {
                Ray ray{{0.0f, 5.0f, 0.0f}, {0.0f, -1.0f, 0.0f}};
                ray.from[axis] = bad;
                CHECK_FALSE(world.cast_ray(ray));
                ray = {{0.0f, 5.0f, 0.0f}, {0.0f, -1.0f, 0.0f}};
                ray.to[axis] = bad;
                CHECK_FALSE(world.cast_ray(ray));
            }
        const float most = std::numeric_limits<float>::max();
        CHECK_FALSE(world.cast_ray({{0.0f, most, 0.0f}, {0.0f, -most, 0.0f}})); // its length is no number
    }
}

TEST_CASE("rays: a box and the ground are met at known places, from outside only") {
    for (const EngineKind engine : engines) {
        CAPTURE(to_string(engine));
        WorldSettings settings = on(engine);
        settings.ground_height = -1.0f;
        World world(settings);
        const BodyId low = must_add(world, box({0.5f, 0.1f, 0.5f}, 1.0f, {0.0f, 1.0f, 0.0f}));
        const BodyId high = must_add(world, box({0.5f, 0.1f, 0.5f}, 1.0f, {0.0f, 2.0f, 0.0f}));
        const auto meets = [&](const Ray& ray, BodyId body, double share, const glm::vec3& normal) {
            const std::optional<RayHit> hit = world.cast_ray(ray);
            REQUIRE(hit);
            CHECK(hit->body == body);
            CHECK(hit->part == 0);
            CHECK(double{hit->share} == doctest::Approx(share).epsilon(engine == EngineKind::solver ? 1e-4 : 1e-3));
            CHECK(glm::distance(hit->normal, normal) < (engine == EngineKind::solver ? 1e-5f : 5e-3f));
            CHECK(glm::distance(hit->point, ray.from + hit->share * (ray.to - ray.from)) < 1e-5f);
        };
        const glm::vec3 up(0.0f, 1.0f, 0.0f);
        meets({{0.2f, 4.0f, 0.1f}, {0.2f, 0.0f, 0.1f}}, high, 1.9 / 4.0, up);
        meets({{0.2f, 1.5f, 0.1f}, {0.2f, -2.5f, 0.1f}}, low, 0.4 / 4.0, up);
        meets({{0.2f, 0.0f, 0.1f}, {0.2f, 4.0f, 0.1f}}, low, 0.9 / 4.0, -up);
        meets({{0.2f, 2.0f, 0.1f}, {0.2f, -2.0f, 0.1f}}, low, 0.9 / 4.0, up);      // begins inside the upper one
        meets({{0.2f, 1.0f, 0.1f}, {0.2f, -3.0f, 0.1f}}, BodyId{}, 2.0 / 4.0, up); // begins inside the lower one
        meets({{-2.0f, 1.0f, 0.1f}, {2.0f, 1.0f, 0.1f}}, low, 1.5 / 4.0, {-1.0f, 0.0f, 0.0f});
        meets({{3.0f, 1.0f, 0.1f}, {5.0f, -3.0f, 0.1f}}, BodyId{}, 0.5, up);
        CHECK_FALSE(world.cast_ray({{0.2f, 2.0f, 0.1f}, {0.2f, 2.05f, 0.1f}}));  // within a body
        CHECK_FALSE(world.cast_ray({{3.0f, -2.0f, 0.0f}, {3.0f, -1.5f, 0.0f}})); // below the ground
        CHECK_FALSE(world.cast_ray({{3.0f, -2.0f, 0.0f}, {3.0f, 5.0f, 0.0f}}));  // out of it
        meets({{3.0f, 0.0f, 0.0f}, {3.0f, -1.0f, 0.0f}}, BodyId{}, 1.0, up);     // ends on it
        CHECK(world.remove_body(high));
        meets({{0.2f, 4.0f, 0.1f}, {0.2f, 0.0f, 0.1f}}, low, 2.9 / 4.0, up);
        world.clear();
        meets({{0.2f, 4.0f, 0.1f}, {0.2f, -4.0f, 0.1f}}, BodyId{}, 5.0 / 8.0, up);
    }
}

TEST_CASE("rays: a kilometre long, they meet a thin plate to a hundredth of a millimetre") {
    World world(empty_space);
    BodyDesc plate = box({0.5f, 0.002f, 0.5f}, 1.0f, {0.0f, 1.0f, 0.0f});
    plate.fixed = true;
    const BodyId body = must_add(world, plate);
    for (const float length : {1.0f, 30.0f, 1000.0f}) {
        const std::optional<RayHit> hit = world.cast_ray({{0.3f, 1.0f + length, 0.2f}, {-0.2f, 1.0f - length, 0.1f}});
        REQUIRE(hit);
        CHECK(hit->body == body);
        CHECK(std::abs(hit->point.y - 1.002f) < 1e-5f);
    }
}

TEST_CASE("rays: in a scene of moving, sleeping and fixed bodies they meet what brute force finds") {
    for (const EngineKind engine : engines) {
        CAPTURE(to_string(engine));
        WorldSettings settings = on(engine, {});
        Scene scene(settings);
        fill(scene);
        const bool exact = engine == EngineKind::solver;
        test::Random random(17);
        size_t met = 0, unsure = 0, ground = 0;
        for (int round = 0; round < 4; ++round) {
            for (int i = 0; i < 25; ++i) scene.world.step();
            const std::vector<Placed> hulls = scene.placed();
            std::vector<Ray> rays;
            for (int i = 0; i < 1500; ++i) {
                const double reach = i % 3 == 0 ? 0.1 : i % 3 == 1 ? 1.0 : 6.0;
                const glm::dvec3 from = random.point({-2.5, -0.1, -2.5}, {2.5, 3.0, 2.5});
                rays.push_back({glm::vec3(from), glm::vec3(from + reach * random.direction())});
            }
            std::vector<std::optional<RayHit>> hits(rays.size(), RayHit{});
            scene.world.cast_rays(rays, hits);
            for (size_t i = 0; i < rays.size(); ++i) {
                const Ray& ray = rays[i];
                CAPTURE(i);
                // Faces of hulls are joined where they enclose little: up to 2 thousandths of the extent.
                const double length = glm::distance(glm::dvec3(ray.from), glm::dvec3(ray.to));
                const double error = exact ? 1e-3 : bullet_error;
                double lowest = 2.0, highest = 2.0; // bounds of the share; above 1: nothing
                bool begins_on = false;
                for (const Placed& hull : hulls) {
                    const double outer = hull.margin + error, inner = (exact ? hull.margin : 0.0) - error;
                    const double height = hull.height(glm::dvec3(ray.from));
                    begins_on |= height < outer && height > inner;
                    lowest = std::min(lowest, hull.entry(ray, outer).value_or(2.0));
                    highest = std::min(highest, hull.entry(ray, inner).value_or(2.0));
                }
                if (ray.from.y > 0.0f && ray.to.y <= 0.0f) {
                    const double share = double{ray.from.y} / (double{ray.from.y} - double{ray.to.y});
                    lowest = std::min(lowest, share);
                    highest = std::min(highest, share);
                }
                if (begins_on) continue;
                unsure += (lowest > 1.0) != (highest > 1.0) ? 1 : 0;
                if (highest <= 1.0) REQUIRE(hits[i]);
                if (!hits[i]) continue;
                ++met;
                REQUIRE(lowest <= 1.0);
                CHECK(double{hits[i]->share} >= lowest - 1e-5);
                CHECK(double{hits[i]->share} <= std::min(highest, 1.0) + 1e-5);
                CHECK(glm::length(hits[i]->normal) == doctest::Approx(1.0));
                CHECK(glm::dot(hits[i]->normal, ray.to - ray.from) < 0.0f);
                if (hits[i]->body == BodyId{}) {
                    ++ground;
                    CHECK(hits[i]->point.y == 0.0f);
                    continue;
                }
                const auto hull = std::ranges::find_if(
                    hulls, [&](const Placed& one) { return one.body == hits[i]->body && one.part == hits[i]->part; });
                REQUIRE(hull != hulls.end());
                const double height = hull->height(glm::dvec3(hits[i]->point));
                CHECK(height < hull->margin + error + 1e-5 * length);
                CHECK(height > (exact ? hull->margin : 0.0) - error - 1e-5 * length);
                if (!exact) continue;
                // The normal is that of a plane in which the point lies.
                const auto plane = std::ranges::find_if(hull->planes, [&](const HullPlane& one) {
                    return glm::dot(one.normal, glm::dvec3(hits[i]->normal)) > 0.998
                           && glm::dot(one.normal, glm::dvec3(hits[i]->point)) - one.distance > hull->margin - error;
                });
                CHECK(plane != hull->planes.end());
            }
        }
        CHECK(met > 1000);
        CHECK(ground > 300);
        CHECK(unsure < (exact ? 60u : 150u));
    }
}

TEST_CASE("rays: one call for many gives what a call for each does, and leaves a run as it is") {
    for (const EngineKind engine : engines) {
        CAPTURE(to_string(engine));
        Scene cast(on(engine, {})), other(on(engine, {}));
        fill(cast);
        fill(other);
        test::Random random(5);
        for (int step = 0; step < 60; ++step) {
            std::vector<Ray> rays;
            for (int i = 0; i < 50; ++i) {
                const glm::dvec3 from = random.point({-2.5, 0.0, -2.5}, {2.5, 3.0, 2.5});
                rays.push_back({glm::vec3(from), glm::vec3(from + 2.0 * random.direction())});
            }
            rays[7].to = rays[7].from;
            rays[20].to.x = NAN;
            std::vector<std::optional<RayHit>> hits(rays.size());
            cast.world.cast_rays(rays, hits);
            for (size_t i = 0; i < rays.size(); ++i) {
                const std::optional<RayHit> alone = cast.world.cast_ray(rays[i]);
                REQUIRE(alone.has_value() == hits[i].has_value());
                if (!alone) continue;
                CHECK(alone->body == hits[i]->body);
                CHECK(alone->part == hits[i]->part);
                CHECK(alone->share == hits[i]->share);
                CHECK(alone->normal == hits[i]->normal);
            }
            cast.world.step();
            other.world.step();
        }
        CHECK(cast.world.state_hash() == other.world.state_hash());
    }
}

TEST_CASE("rays: a body that moved after the step is met where it is") {
    for (const EngineKind engine : engines) {
        CAPTURE(to_string(engine));
        World world(on(engine));
        const BodyId body = must_add(world, box(glm::vec3(0.1f), 1.0f, {0.0f, 0.0f, 0.0f}));
        world.step();
        world.set_velocity(body, {60.0f, 0.0f, 0.0f}, {});
        world.move_on(body, 0.05f); // to x = 3
        CHECK_FALSE(world.cast_ray({{0.0f, 1.0f, 0.0f}, {0.0f, -1.0f, 0.0f}}));
        const std::optional<RayHit> hit = world.cast_ray({{3.0f, 1.0f, 0.0f}, {3.0f, -1.0f, 0.0f}});
        REQUIRE(hit);
        CHECK(hit->body == body);
        CHECK(hit->share == doctest::Approx(0.45).epsilon(0.002));
    }
}

TEST_CASE("rays: of hulls that are entered at the same point, the first body and the lowest part count") {
    World world(empty_space);
    BodyDesc twice = box(glm::vec3(0.5f), 1.0f, glm::vec3(0.0f));
    const auto hull = std::make_shared<const CollisionHull>(twice.hull);
    twice.hull = {};
    // The tree of the parts visits them from low to high x.
    for (int i = 0; i < 9; ++i) twice.parts.push_back({hull, {0.4f - 0.1f * static_cast<float>(i), 0.0f, 0.0f}});
    twice.fixed = true;
    const BodyId first = must_add(world, twice);
    must_add(world, twice);
    const std::optional<RayHit> hit = world.cast_ray({{0.0f, 2.0f, 0.2f}, {0.0f, 0.0f, 0.2f}});
    REQUIRE(hit);
    CHECK(hit->body == first);
    CHECK(hit->part == 0);
}
