// The C++ side of test_c.c: the same fracture and the same run, without the C interface.
#include <cmath>
#include <cstdint>
#include <cstdio>

#include "fracture/fracture.h"
#include "fracture/io/import.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/pattern.h"
#include "physics/cutting/destruction.h"
#include "physics/material.h"

using namespace brittle;

extern "C" uint64_t core_hash(const char* path, uint32_t count, uint64_t seed, double roughness) {
    const fracture::Result<fracture::TriangleMesh> mesh = fracture::import_mesh(path);
    if (!mesh) return 0;
    const auto sites = fracture::make_sites({.count = count, .seed = seed, .inside = true}, *mesh);
    if (!sites) return 0;
    const auto pieces = fracture::fracture(*mesh, sites->sites, {.rough = {.amount = roughness}});
    return pieces ? fracture::hash(*pieces) : 0;
}

extern "C" uint64_t core_state_hash() {
    physics::World world;
    physics::Destruction destruction;
    const fracture::TriangleMesh cube = fracture::cube();
    physics::BreakableDesc desc;
    const physics::MaterialPreset& stone = *physics::material_preset("stone");
    desc.solid.material = physics::scale_strength(stone.material, physics::flawed_strength);
    desc.solid.blocks.strength_scale /= physics::flawed_strength;
    desc.pattern.kind = stone.pattern.kind;
    desc.pattern.slenderness = stone.pattern.slenderness;
    desc.motion.placement.position.y = 1.0f;
    if (!destruction.add(world, cube, desc)) return 0;
    const double impulse = std::sqrt(2.0 * 20000.0);
    destruction.strike(world, destruction.pieces().front(), {0.0f, 1.0f, 1.0f}, {0.0f, 0.0f, -1.0f}, 20000.0,
                       impulse / static_cast<double>(physics::impact_seconds));
    const fracture::TriangleMesh sphere = fracture::icosphere(2, static_cast<double>(0.2f));
    const fracture::MassProperties mass = fracture::mass_properties(sphere.positions, sphere.triangles);
    physics::BodyDesc ball;
    ball.hull = physics::collision_hull(sphere.positions, mass.centre_of_mass, {.max_vertices = 64});
    ball.mass = 7800.0f * static_cast<float>(mass.volume);
    ball.inertia = glm::mat3(mass.inertia) * 7800.0f;
    ball.pose.position = {0.0f, 1.0f, 5.0f};
    ball.linear_velocity.z = -20.0f;
    if (!world.add_body(ball)) return 0;
    for (int step = 0; step < 60; ++step) {
        world.step();
        destruction.update(world);
    }
    return (world.state_hash() * 1099511628211ull) ^ destruction.state_hash();
}
