// Prints the hash of the state after each of eight runs: what every compiler, optimisation level and number of threads
// must agree on. tests/physics/hashes.txt holds what it printed; tools/check-hashes compares, --update writes it anew.
//
//     physics_hashes [--steps]     --steps: also the hash every 30 steps, to find the first that differs
//
// Rigid bodies alone, bonded pieces, and pieces that are cut while the run goes on.
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "fracture/base/random.h"
#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "physics/bonds/anchor.h"
#include "physics/bonds/structure.h"
#include "physics/cutting/destruction.h"
#include "physics/world/hull.h"
#include "physics/world/pieces.h"
#include "physics/world/state_hash.h"
#include "physics/world/world.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

template<class T>
T must(Result<T> result) {
    if (result) return std::move(*result);
    std::fprintf(stderr, "physics_hashes: %s\n", result.error().message.c_str());
    std::exit(1);
}

// A run: the world, what may break in it, and the hash of every state that it has gone through.
struct Run {
    World world;
    StateHash hash{};
    bool show_steps;

    Run(const WorldSettings& settings, bool show) : world(settings), show_steps(show) {}

    void look(uint64_t more = 0) {
        hash.add(world.state_hash());
        hash.add(more);
        if (show_steps && world.steps_taken() % 30 == 0)
            std::printf("    step %4" PRIu64 "  %016" PRIx64 "\n", world.steps_taken(), hash.value());
    }
    void steps(int count) {
        for (int i = 0; i < count; ++i) {
            world.step();
            look();
        }
    }
    void steps(int count, Structure& structure) {
        for (int i = 0; i < count; ++i) {
            world.step();
            (void)structure.update(world);
            look(structure.state_hash());
        }
    }
    void steps(int count, Destruction& destruction) {
        for (int i = 0; i < count; ++i) {
            world.step();
            destruction.update(world);
            look(destruction.state_hash());
        }
    }
};

CollisionHull box_hull(const glm::vec3& half) {
    std::vector<glm::dvec3> corners;
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0})
            for (const double z : {-1.0, 1.0}) corners.push_back(glm::dvec3(half) * glm::dvec3(x, y, z));
    return collision_hull(corners, glm::dvec3(0.0));
}

BodyDesc box(const glm::vec3& half, float mass, const glm::vec3& position) {
    BodyDesc desc;
    desc.hull = box_hull(half);
    desc.mass = mass;
    const glm::vec3 square = half * half * (mass / 3.0f);
    desc.inertia = glm::mat3(0.0f);
    desc.inertia[0][0] = square.y + square.z;
    desc.inertia[1][1] = square.x + square.z;
    desc.inertia[2][2] = square.x + square.y;
    desc.pose.position = position;
    return desc;
}

BodyDesc ball(float radius, float mass, const glm::vec3& position, const glm::vec3& velocity) {
    const fracture::TriangleMesh mesh = fracture::icosphere(1, static_cast<double>(radius));
    BodyDesc desc;
    desc.hull = collision_hull(mesh.positions, glm::dvec3(0.0), {.max_vertices = 42});
    desc.mass = mass;
    desc.inertia = glm::mat3(0.4f * mass * radius * radius);
    desc.pose.position = position;
    desc.linear_velocity = velocity;
    return desc;
}

fracture::Fragments pieces_of(const fracture::TriangleMesh& mesh, uint32_t count) {
    return must(fracture::fracture(mesh, fracture::uniform_sites(fracture::bounds(mesh), count, 1)));
}

fracture::TriangleMesh slab(const glm::dvec3& half) {
    fracture::TriangleMesh mesh = fracture::cube();
    const fracture::Box box = fracture::bounds(mesh);
    for (glm::dvec3& p : mesh.positions) p = (p - box.centre()) / box.size() * 2.0 * half;
    return mesh;
}

// Bodies of three different moments, some turning about the middle one, in still air without gravity.
void tumbling(Run& run) {
    fracture::Random random(7);
    for (int i = 0; i < 24; ++i) {
        BodyDesc desc = box({0.05f, 0.1f, 0.2f}, 2.0f, {static_cast<float>(i), 0.0f, 0.0f});
        desc.angular_velocity = {0.01f, 1.0f + static_cast<float>(i), 0.01f * static_cast<float>(random.uniform())};
        desc.linear_velocity = {0.0f, static_cast<float>(random.uniform()) * 5.0f, 1.0f};
        (void)must(run.world.add_body(desc));
    }
    run.steps(240);
}

// Boxes with friction and bounce of their own, thrown along the ground and at each other.
void sliding(Run& run) {
    for (int i = 0; i < 20; ++i) {
        const auto x = static_cast<float>(i);
        BodyDesc desc = box({0.1f, 0.05f, 0.15f}, 1.0f + x, {0.3f * x, 0.06f + 0.02f * x, 0.0f});
        desc.friction = 0.05f * x;
        desc.restitution = 0.04f * x;
        desc.linear_velocity = {i % 2 == 0 ? 2.0f : -2.0f, 0.0f, 0.5f};
        desc.angular_velocity = {0.0f, x, 1.0f};
        (void)must(run.world.add_body(desc));
    }
    run.steps(360);
}

// Boxes on each other, until they sleep, and a ball that wakes them.
void stacks(Run& run) {
    for (int column = 0; column < 6; ++column)
        for (int row = 0; row < 5; ++row)
            (void)must(run.world.add_body(
                box({0.1f, 0.1f, 0.1f}, 1.0f,
                    {0.5f * static_cast<float>(column), 0.1f + 0.2f * static_cast<float>(row), 0.0f})));
    run.steps(240);
    (void)must(run.world.add_body(ball(0.15f, 5.0f, {-2.0f, 0.5f, 0.0f}, {8.0f, 1.0f, 0.0f})));
    run.steps(240);
}

// Pieces of a ball that fall in a heap.
void heap(Run& run) {
    const fracture::Fragments fragments = pieces_of(fracture::icosphere(3), 150);
    (void)must(add_pieces(run.world, fragments, {}, {.placement = {.position = {0.0f, 2.0f, 0.0f}}}));
    run.steps(360);
}

// More pieces than may collide with each other, half of them debris by their size, which fall onto what is fixed.
void debris(Run& run) {
    BodyDesc shelf = box({0.4f, 0.05f, 0.4f}, 1.0f, {0.3f, 0.5f, 0.0f});
    shelf.fixed = true;
    (void)must(run.world.add_body(shelf));
    const fracture::Fragments fragments = pieces_of(fracture::torus(), 700);
    (void)must(add_pieces(run.world, fragments, {}, {.placement = {.position = {0.0f, 2.5f, 0.0f}}}));
    run.steps(240);
}

// Bodies of several hulls, and thin things at high speed that must not pass through what is thin and fixed.
void compounds(Run& run) {
    BodyDesc pane = box({1.0f, 1.0f, 0.01f}, 1.0f, {0.0f, 1.0f, 2.0f});
    pane.fixed = true;
    (void)must(run.world.add_body(pane));
    const auto slab_hull = std::make_shared<const CollisionHull>(box_hull({0.05f, 0.1f, 0.05f}));
    for (int i = 0; i < 12; ++i) {
        const auto x = static_cast<float>(i);
        BodyDesc desc = box({0.15f, 0.1f, 0.05f}, 2.0f, {0.2f * x - 1.0f, 0.5f + 0.25f * x, 0.05f * x});
        desc.hull = {};
        for (const float at : {-0.1f, 0.0f, 0.1f}) desc.parts.push_back({slab_hull, {at, 0.0f, 0.0f}});
        desc.angular_velocity = {x, 0.0f, 1.0f};
        (void)must(run.world.add_body(desc));
    }
    for (int i = 0; i < 8; ++i) {
        BodyDesc dart = box({0.02f, 0.02f, 0.08f}, 0.2f, {0.2f * static_cast<float>(i) - 0.7f, 0.4f, -2.0f});
        dart.linear_velocity = {0.0f, 2.0f, 20.0f + 10.0f * static_cast<float>(i)};
        (void)must(run.world.add_body(dart));
    }
    run.steps(240);
}

// A wall of bonded pieces that stands on the ground, and a ball that goes through it.
void bonded_wall(Run& run) {
    const fracture::Fragments fragments = pieces_of(slab({1.0, 0.8, 0.1}), 80);
    StructureDesc desc;
    desc.motion.placement.position = {0.0f, 0.81f, 0.0f};
    desc.anchored = anchor_to_ground(fragments, desc.motion.placement, 0.0f, 0.03f);
    Structure wall = must(Structure::create(run.world, fragments, desc));
    run.steps(30, wall);
    (void)must(run.world.add_body(ball(0.15f, 60.0f, {0.2f, 0.9f, 2.0f}, {0.0f, 0.0f, -14.0f})));
    run.steps(240, wall);
}

// A held pane and a free ball of weak concrete, struck by hand, shot at and dropped; pieces are cut again.
void breakable(Run& run) {
    Destruction destruction({.latency = 2});
    const Material weak{.tensile = 3e5f, .fracture_energy = 100.0f};
    BreakableDesc pane;
    pane.solid.material = weak;
    pane.solid.min_size = 0.05;
    pane.solid.anchors = {fracture::Box{{-2.0, -1.0, -1.0}, {2.0, -0.45, 1.0}}};
    pane.motion.placement.position = {0.0f, 0.5f, 0.0f};
    (void)must(destruction.add(run.world, slab({0.6, 0.5, 0.05}), pane));
    BreakableDesc stone;
    stone.solid.material = weak;
    stone.solid.min_size = 0.06;
    stone.pattern.seed = 3;
    stone.motion.placement.position = {1.5f, 2.0f, 0.0f};
    stone.motion.linear_velocity = {0.0f, -8.0f, 0.0f};
    (void)must(destruction.add(run.world, fracture::icosphere(3, 0.3), stone));
    run.steps(20, destruction);
    const PieceId first = destruction.pieces().front();
    (void)destruction.strike(run.world, first, {0.1f, 0.6f, 0.05f}, {0.0f, 0.0f, -1.0f}, 400.0);
    run.steps(60, destruction);
    (void)must(run.world.add_body(ball(0.1f, 8.0f, {-0.2f, 0.7f, 2.0f}, {0.0f, 0.0f, -15.0f})));
    run.steps(280, destruction);
    if (run.show_steps)
        std::printf("    %zu pieces, %u breaks\n", destruction.pieces().size(), destruction.statistics().breaks);
}

bool print(const char* name, const std::function<void(Run&)>& play, bool show_steps, WorldSettings settings = {}) {
    uint64_t first = 0;
    for (const uint32_t threads : {1u, 2u, 4u}) {
        settings.threads = threads;
        Run run(settings, show_steps && threads == 1);
        play(run);
        if (threads == 1) first = run.hash.value();
        if (run.hash.value() != first) return std::printf("%s: differs with %u threads\n", name, threads), false;
    }
    std::printf("%-12s %016" PRIx64 "\n", name, first);
    std::fflush(stdout);
    return true;
}

} // namespace

int main(int argc, char** argv) {
    const bool steps = argc == 2 && std::strcmp(argv[1], "--steps") == 0;
    if (argc > 1 && !steps) {
        std::fprintf(stderr, "usage: physics_hashes [--steps]\n");
        return 2;
    }
    bool good = print("tumbling", tumbling, steps, {.gravity = {0.0f, 0.0f, 0.0f}, .ground_height = {}});
    good &= print("sliding", sliding, steps);
    good &= print("stacks", stacks, steps);
    good &= print("heap", heap, steps);
    good &= print("debris", debris, steps, {.debris_size = 0.1f});
    good &= print("compounds", compounds, steps);
    good &= print("bonded_wall", bonded_wall, steps);
    good &= print("breakable", breakable, steps);
    return good ? 0 : 1;
}
