#include "tools/bench/scenes.h"

#include <cmath>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/base/random.h"
#include "fracture/mesh/convex_hull.h"
#include "fracture/mesh/islands.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/shapes/shapes.h"
#include "physics/world/hull.h"

namespace brittle::tools {

namespace {

using physics::BodyDesc;

constexpr double ball_radius = 0.1;    // m
constexpr double card_density = 700.0; // kg/m^3
constexpr double foot_friction = 1.5;  // of a domino on the ground
constexpr double first_push = 4.0;     // rad/s, of the first domino: half as much again as tips it over

std::vector<glm::dvec3> box_corners(const glm::dvec3& size) {
    std::vector<glm::dvec3> corners;
    for (const double x : {-0.5, 0.5})
        for (const double y : {-0.5, 0.5})
            for (const double z : {-0.5, 0.5}) corners.push_back(size * glm::dvec3(x, y, z));
    return corners;
}

// A body for each solid of a mesh, in their order.
Scene solids(const fracture::TriangleMesh& mesh, double density = stone_density) {
    Scene scene;
    const std::vector<fracture::FaceSource> sources(mesh.triangles.size());
    for (const fracture::Island& solid : fracture::split_islands(mesh.positions, mesh.triangles, sources))
        add_convex(scene, solid.positions, density);
    return scene;
}

void turn_about_z(BodyDesc& body, double angle) {
    body.pose.orientation = glm::quat(glm::dquat(std::cos(0.5 * angle), 0.0, 0.0, std::sin(0.5 * angle)));
}

constexpr double stir_speed = 1.0;  // rad/s
constexpr double beam_height = 1.0; // m, of the middle of the junkyard's beam

// `count` random points in a shell of 0.8 to 1 radii.
std::vector<glm::dvec3> rock(fracture::Random& random, int count, double radius) {
    std::vector<glm::dvec3> points;
    while (points.size() < static_cast<size_t>(count)) {
        const glm::dvec3 at = random.uniform_in({glm::dvec3(-1.0), glm::dvec3(1.0)});
        const double length = glm::length(at);
        if (length > 0.1 && length < 1.0) points.push_back(at / length * radius * (0.8 + 0.2 * random.uniform()));
    }
    return points;
}

// Rocks in layers of side x side, the lowest one `height` above the ground.
void add_rocks(Scene& scene, int side, int layers, int points, double radius, double height) {
    fracture::Random random(1);
    const double pitch = 2.05 * radius;
    for (int layer = 0; layer < layers; ++layer)
        for (int i = 0; i < side * side; ++i) {
            const glm::dvec3 at(pitch * (i % side - 0.5 * (side - 1)), height + radius + pitch * layer,
                                pitch * (i / side - 0.5 * (side - 1)));
            add_convex(scene, rock(random, points, radius)).pose.position += glm::vec3(at);
        }
}

} // namespace

BodyDesc& add_convex(Scene& scene, std::span<const glm::dvec3> points, double density, uint32_t max_vertices) {
    glm::dvec3 middle(0.0);
    for (const glm::dvec3& point : points) middle += point / static_cast<double>(points.size());
    std::vector<glm::vec3> around;
    for (const glm::dvec3& point : points) around.emplace_back(point - middle);
    const fracture::TriangleMesh mesh = fracture::convex_hull(around);
    const fracture::MassProperties mass = fracture::mass_properties(mesh.positions, mesh.triangles);
    const glm::dvec3 centre = middle + mass.centre_of_mass;
    std::vector<glm::dvec3>& solid = scene.solids.emplace_back(points.begin(), points.end());
    for (glm::dvec3& point : solid) point -= centre;
    BodyDesc& body = scene.bodies.emplace_back();
    body.hull = physics::collision_hull(points, centre, {.max_vertices = max_vertices});
    body.mass = static_cast<float>(density * mass.volume);
    body.inertia = glm::mat3(density * mass.inertia);
    body.pose.position = glm::vec3(centre);
    body.restitution = 0.0f;
    return body;
}

BodyDesc& add_box(Scene& scene, const glm::dvec3& size, const glm::dvec3& centre, double density) {
    BodyDesc& body = add_convex(scene, box_corners(size), density);
    body.pose.position = glm::vec3(centre);
    return body;
}

void set_friction(Scene& scene, double coefficient) {
    const auto root = static_cast<float>(std::sqrt(coefficient));
    scene.settings.ground_friction = root;
    for (BodyDesc& body : scene.bodies) body.friction = root;
}

Scene stack(int count, double edge) {
    Scene scene = solids(fracture::stack(static_cast<uint32_t>(count), edge, 0.0));
    set_friction(scene, 0.5);
    return scene;
}

Scene loaded_stack(int count, double edge, double ratio) {
    Scene scene = stack(count + 1, edge);
    BodyDesc& load = scene.bodies.back();
    load.mass *= static_cast<float>(ratio);
    load.inertia *= static_cast<float>(ratio);
    return scene;
}

Scene card_house(int levels) {
    Scene scene = solids(fracture::card_house(static_cast<uint32_t>(levels), 0.0), card_density);
    set_friction(scene, 0.49);
    return scene;
}

Scene arch(double thickness, int stones, double friction) {
    Scene scene = solids(fracture::stone_arch(thickness, static_cast<uint32_t>(stones), 0.0));
    scene.settings.ground_height = {};
    for (const double side : {-1.0, 1.0}) add_box(scene, {0.6, 0.4, 1.0}, {side, -0.2, 0.0}).fixed = true;
    set_friction(scene, friction);
    return scene;
}

Scene pyramid(int rows, double edge) {
    Scene scene = solids(fracture::pyramid(static_cast<uint32_t>(rows), edge, 0.0));
    set_friction(scene, 0.5);
    return scene;
}

Scene slope(double angle, double friction) {
    Scene scene;
    scene.settings.ground_height = {};
    scene.settings.air_density = 0.0f;
    constexpr double slab_half = 0.25, box_half = 0.05, start = 4.0;
    const glm::dvec3 along(std::cos(angle), std::sin(angle), 0.0), up(-std::sin(angle), std::cos(angle), 0.0);
    add_box(scene, {0.2, 2.0 * box_half, 0.2}, start * along + box_half * up);
    add_box(scene, {12.0, 2.0 * slab_half, 2.0}, -slab_half * up).fixed = true;
    for (BodyDesc& body : scene.bodies) turn_about_z(body, angle);
    set_friction(scene, friction);
    return scene;
}

Scene drop(Dropped what, double restitution, bool on_slab, double height) {
    Scene scene;
    scene.settings.air_density = 0.0f;
    scene.settings.ground_restitution = 1.0f;
    const std::vector<glm::dvec3> points = what == Dropped::ball ? fracture::icosphere(2, ball_radius).positions
                                                                 : box_corners(glm::dvec3(2.0 * ball_radius));
    BodyDesc& body = add_convex(scene, points, stone_density, 64);
    body.pose.position = {0.0f, static_cast<float>(height + ball_radius), 0.0f};
    body.restitution = static_cast<float>(restitution);
    if (on_slab) {
        scene.settings.ground_height = {};
        BodyDesc& slab = add_box(scene, {2.0, 0.5, 2.0}, {0.0, -0.25, 0.0});
        slab.fixed = true;
        slab.restitution = 1.0f;
    }
    return scene;
}

Scene dominoes(const Dominoes& row) {
    Scene scene;
    scene.settings.air_density = 0.0f;
    add_box(scene, {row.thickness, row.height, row.width}, {0.0, 0.5 * row.height, 0.0}, 1200.0);
    scene.bodies.resize(static_cast<size_t>(row.count), BodyDesc(scene.bodies.front()));
    scene.solids.resize(static_cast<size_t>(row.count), std::vector(scene.solids.front()));
    set_friction(scene, row.friction);
    scene.settings.ground_friction = static_cast<float>(foot_friction / std::sqrt(row.friction));
    for (size_t i = 0; i < scene.bodies.size(); ++i)
        scene.bodies[i].pose.position.x = static_cast<float>(static_cast<double>(i) * (row.thickness + row.gap));
    // About the front edge of the foot.
    BodyDesc& first = scene.bodies.front();
    first.angular_velocity = {0.0f, 0.0f, static_cast<float>(-first_push)};
    first.linear_velocity =
        glm::cross(first.angular_velocity, glm::vec3(glm::dvec3(-0.5 * row.thickness, 0.5 * row.height, 0.0)));
    return scene;
}

Scene convex_pile() {
    Scene scene;
    add_rocks(scene, 16, 20, 32, 0.5, 0.1);
    set_friction(scene, 0.5);
    return scene;
}

Scene junkyard() {
    Scene scene;
    constexpr double radius = 0.25, half = 6.0, wall = 0.5, wall_height = 16.0;
    add_rocks(scene, 21, 24, 12, radius, 2.0 * beam_height);
    for (const double side : {-1.0, 1.0})
        for (const bool along_x : {false, true}) {
            const double away = side * (half + 0.5 * wall), length = 2.0 * (half + wall);
            add_box(scene, along_x ? glm::dvec3(length, wall_height, wall) : glm::dvec3(wall, wall_height, length),
                    {along_x ? 0.0 : away, 0.5 * wall_height, along_x ? away : 0.0})
                .fixed = true;
        }
    // A thousand times as dense as a rock: it keeps its speed.
    add_box(scene, {10.0, 0.5, 0.5}, {0.0, beam_height, 0.0}, 1000.0 * stone_density);
    set_friction(scene, 0.5);
    return scene;
}

void stir(physics::World& world, physics::BodyId beam) {
    // The step's gravity is added to this velocity.
    const auto step = world.settings().step;
    const glm::vec3 away = glm::vec3(0.0f, static_cast<float>(beam_height), 0.0f) - world.pose(beam).position;
    world.set_velocity(beam, away / step - world.settings().gravity * step,
                       {0.0f, static_cast<float>(stir_speed), 0.0f});
}

Scene many_pyramids() {
    const Scene one = pyramid(10, 0.5);
    Scene scene;
    scene.settings = one.settings;
    for (int i = 0; i < 14; ++i)
        for (int j = 0; j < 14; ++j) {
            scene.solids.insert(scene.solids.end(), one.solids.begin(), one.solids.end());
            for (const BodyDesc& cube : one.bodies) {
                scene.bodies.push_back(cube);
                scene.bodies.back().pose.position +=
                    glm::vec3(6.5f * static_cast<float>(i), 0.0f, static_cast<float>(j));
            }
        }
    return scene;
}

Scene dzhanibekov() {
    Scene scene;
    scene.settings.gravity = glm::vec3(0.0f);
    scene.settings.ground_height = {};
    scene.settings.air_density = 0.0f;
    // X has the least moment and Y the greatest.
    add_box(scene, {0.3, 0.1, 0.2}, glm::dvec3(0.0), 1000.0).angular_velocity = {0.01f, 0.01f, 10.0f};
    return scene;
}

} // namespace brittle::tools
