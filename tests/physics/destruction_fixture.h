// Helpers for tests of destruction: a weak material, balls, runs, and sums over pieces.
#pragma once

#include <algorithm>

#include <doctest/doctest.h>

#include "fracture/shapes/shapes.h"
#include "physics/cutting/destruction.h"
#include "physics/world/hull.h"
#include "tests/physics/run_log.h"

namespace brittle::physics::test_destruction {

// A tenth of concrete's strength, so that small blows break it.
inline const Material weak{.tensile = 3e5f, .fracture_energy = 100.0f};

inline BreakableDesc desc_of(double min_size, const Material& material = weak) {
    BreakableDesc desc;
    desc.solid.material = material;
    desc.solid.min_size = min_size;
    return desc;
}

inline ObjectId must_add(Destruction& destruction, World& world, const fracture::TriangleMesh& mesh,
                         const BreakableDesc& desc) {
    const Result<ObjectId> object = destruction.add(world, mesh, desc);
    REQUIRE_MESSAGE(object.has_value(), (object ? std::string() : object.error().message));
    return *object;
}

// Strikes the top of the piece's bounding ball, downwards.
inline bool strike_from_above(const World& world, Destruction& destruction, PieceId piece, double energy) {
    const glm::vec3 centre = world.pose(destruction.body(piece)).position;
    const glm::vec3 point = centre + glm::vec3(0.0f, destruction.solid(piece)->radius, 0.0f);
    return destruction.strike(world, piece, point, {0.0f, -1.0f, 0.0f}, energy);
}

inline BodyId shoot(World& world, float radius, float mass, const glm::vec3& position, const glm::vec3& velocity) {
    const fracture::TriangleMesh mesh = fracture::icosphere(1, static_cast<double>(radius)); // evenly spread vertices
    BodyDesc desc;
    desc.hull = collision_hull(mesh.positions, glm::dvec3(0.0), {.max_vertices = 42});
    desc.mass = mass;
    desc.inertia = glm::mat3(0.4f * mass * radius * radius);
    desc.pose.position = position;
    desc.linear_velocity = velocity;
    return *world.add_body(desc);
}

inline void run(World& world, Destruction& destruction, int steps, RunLog* log = nullptr) {
    for (int i = 0; i < steps; ++i) {
        world.step();
        destruction.update(world);
        if (log) log->look(world);
    }
}

inline double volume_of(const Destruction& destruction) {
    double sum = 0.0;
    for (const PieceId piece : destruction.pieces()) sum += destruction.solid(piece)->mass.volume;
    return sum;
}

inline PieceId largest(const Destruction& destruction) {
    PieceId best;
    double most = 0.0;
    for (const PieceId piece : destruction.pieces())
        if (const double volume = destruction.solid(piece)->mass.volume; volume > most) most = volume, best = piece;
    return best;
}

} // namespace brittle::physics::test_destruction
