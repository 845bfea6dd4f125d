// Destruction in the C interface: a world with breakable objects, and what changes in it.
#include <cmath>
#include <set>

#include <glm/geometric.hpp>

#include "bindings/c/events.h"
#include "bindings/c/handles.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/shapes/shapes.h"
#include "physics/bonds/anchor.h"
#include "physics/cutting/destruction.h"
#include "physics/cutting/running_bond.h"
#include "physics/material.h"

using namespace brittle;

struct brittle_world {
    brittle_world(const physics::WorldSettings& world_settings, const physics::DestructionSettings& settings)
        : world(world_settings), destruction(settings) {}

    physics::World world;
    physics::Destruction destruction;
    std::set<physics::ObjectId> objects;
};

namespace brittle::c {

namespace {

constexpr uint32_t ball_subdivisions = 2;

brittle_world_settings world_defaults() {
    const physics::WorldSettings world;
    const physics::DestructionSettings destruction;
    brittle_world_settings settings{};
    settings.struct_size = sizeof settings;
    settings.threads = world.threads;
    settings.workers = destruction.workers;
    settings.max_pieces = static_cast<uint32_t>(destruction.debris.max_pieces);
    settings.latency = destruction.latency;
    settings.has_ground = 1;
    for (int k = 0; k < 3; ++k) settings.gravity[k] = world.gravity[k];
    settings.step = world.step;
    return settings;
}

std::unique_ptr<brittle_world> make_world(const brittle_world_settings& given) {
    physics::WorldSettings world;
    world.engine = given.bullet != 0 ? physics::EngineKind::bullet : physics::EngineKind::solver;
    world.threads = given.threads;
    world.gravity = {given.gravity[0], given.gravity[1], given.gravity[2]};
    world.step = given.step;
    world.ground_height = given.has_ground != 0 ? std::optional(given.ground_height) : std::nullopt;
    must(physics::validate(world));
    physics::DestructionSettings destruction;
    destruction.workers = static_cast<uint32_t>(in_range(given.workers, 1, 64, "settings.workers"));
    destruction.latency = static_cast<uint32_t>(in_range(given.latency, 1, 1e6, "settings.latency"));
    destruction.debris.max_pieces = static_cast<size_t>(in_range(given.max_pieces, 1, 1e9, "settings.max_pieces"));
    return std::make_unique<brittle_world>(world, destruction);
}

brittle_object_settings object_defaults() {
    const physics::BreakableDesc desc;
    brittle_object_settings settings{};
    settings.struct_size = sizeof settings;
    settings.max_pieces = desc.max_pieces;
    settings.strength = static_cast<double>(physics::flawed_strength);
    settings.min_size = desc.solid.min_size;
    settings.roughness = -1.0;
    settings.seed = desc.pattern.seed;
    settings.orientation[3] = 1.0f;
    return settings;
}

std::vector<physics::AnchorRegion> anchors_of(const brittle_object_settings& given) {
    std::vector<physics::AnchorRegion> regions;
    if (given.anchor_count == 0) return regions;
    need(given.anchors, "settings.anchors");
    in_range(given.anchor_count, 0, 1e6, "settings.anchor_count");
    for (uint32_t k = 0; k < given.anchor_count; ++k)
        regions.push_back(physics::Ball{read_vector(given.anchors[k].centre, "the centre of an anchor"),
                                        in_range(given.anchors[k].radius, 1e-30, 1e30, "the radius of an anchor")});
    return regions;
}

// `whole`: an object that is not in pieces yet.
physics::BreakableDesc desc_of(const brittle_object_settings& given, const fracture::Box& box, bool whole) {
    const physics::MaterialPreset& preset = preset_of(given.material);
    physics::BreakableDesc desc;
    const auto strength = static_cast<float>(in_range(given.strength, 1e-6, 1e6, "settings.strength"));
    desc.solid.material = physics::scale_strength(preset.material, strength);
    desc.solid.blocks.strength_scale /=
        physics::flawed_strength; // a share of handbook strength; the material is scaled
    desc.solid.min_size = in_range(given.min_size, 1e-6, 1e6, "settings.min_size");
    desc.solid.rough = preset.rough;
    desc.solid.rough.seed = given.seed;
    if (!(given.roughness < 0.0)) // NaN is refused
        desc.solid.rough.amount = in_range(given.roughness, 0.0, 1.0, "settings.roughness");
    desc.solid.anchors = anchors_of(given);
    const bool laid = preset.pattern.kind == fracture::PatternKind::bricks && !whole; // a single brick crumbles
    desc.pattern.kind = laid ? fracture::PatternKind::uniform : preset.pattern.kind;
    desc.pattern.slenderness = preset.pattern.slenderness;
    desc.pattern.seed = given.seed;
    desc.pattern.bond = physics::fitted(desc.pattern.bond, box);
    desc.max_pieces = static_cast<uint32_t>(in_range(given.max_pieces, 2, 10000, "settings.max_pieces"));
    desc.motion.placement.position = read_vector(given.position, "settings.position");
    const float* const q = given.orientation;
    const float length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 0.5f && length < 2.0f))
        refuse("settings.orientation has the length " + std::to_string(length) + "; it must be a unit quaternion",
               BRITTLE_INVALID_SETTING);
    desc.motion.placement.orientation = glm::quat(q[3] / length, q[0] / length, q[1] / length, q[2] / length);
    desc.motion.linear_velocity = read_vector(given.linear_velocity, "settings.linear_velocity");
    desc.motion.angular_velocity = read_vector(given.angular_velocity, "settings.angular_velocity");
    return desc;
}

physics::BodyDesc ball(const glm::vec3& from, const glm::vec3& velocity, float radius, float density) {
    const fracture::TriangleMesh sphere = fracture::icosphere(ball_subdivisions, static_cast<double>(radius));
    const fracture::MassProperties mass = fracture::mass_properties(sphere.positions, sphere.triangles);
    physics::BodyDesc body;
    // As round as the engine allows, so that the ball rolls.
    body.hull = physics::collision_hull(sphere.positions, mass.centre_of_mass, {.max_vertices = 64});
    body.mass = density * static_cast<float>(mass.volume);
    body.inertia = glm::mat3(mass.inertia) * density;
    body.pose.position = from;
    body.linear_velocity = velocity;
    return body;
}

} // namespace

} // namespace brittle::c

using c::guarded;
using c::must;
using c::need;
using c::refuse;

extern "C" {

void brittle_world_settings_init(brittle_world_settings* settings, size_t struct_size) {
    c::init_struct(settings, struct_size, c::world_defaults());
}

brittle_status brittle_world_create(const brittle_world_settings* settings, brittle_world** out, brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        *out = c::make_world(c::read_settings(settings, c::world_defaults(), "settings")).release();
    });
}

void brittle_world_free(brittle_world* world) {
    delete world;
}

void brittle_object_settings_init(brittle_object_settings* settings, size_t struct_size) {
    c::init_struct(settings, struct_size, c::object_defaults());
}

brittle_status brittle_world_add_breakable(brittle_world* world, const brittle_mesh* mesh,
                                           const brittle_object_settings* settings, uint32_t* object,
                                           brittle_error* error) {
    return guarded(error, [&] {
        brittle_world& w = need(world, "world");
        const fracture::TriangleMesh& triangles = need(mesh, "mesh").model->mesh;
        const physics::BreakableDesc desc =
            c::desc_of(c::read_settings(settings, c::object_defaults(), "settings"), fracture::bounds(triangles), true);
        const physics::ObjectId id = must(w.destruction.add(w.world, triangles, desc));
        w.objects.insert(id);
        if (object) *object = id.value;
    });
}

brittle_status brittle_world_add_bonded(brittle_world* world, const brittle_pieces* pieces,
                                        const brittle_object_settings* settings, uint32_t* object,
                                        brittle_error* error) {
    return guarded(error, [&] {
        brittle_world& w = need(world, "world");
        const fracture::Fragments& fragments = need(pieces, "pieces").fragments;
        if (fragments.pieces.empty()) refuse("there are no pieces");
        const physics::BreakableDesc desc = c::desc_of(c::read_settings(settings, c::object_defaults(), "settings"),
                                                       fracture::bounds(fragments.positions), false);
        physics::StructureDesc structure{.material = desc.solid.material, .motion = desc.motion};
        structure.wear.strength_scale /= physics::flawed_strength; // as HeldBlockSettings::strength_scale
        structure.anchored = physics::anchor_to(fragments, desc.solid.anchors);
        const physics::ObjectId id = must(w.destruction.add(w.world, fragments, structure, desc));
        w.objects.insert(id);
        if (object) *object = id.value;
    });
}

brittle_status brittle_world_remove(brittle_world* world, uint32_t object, brittle_error* error) {
    return guarded(error, [&] {
        brittle_world& w = need(world, "world");
        if (w.objects.erase({object}) == 0) refuse("there is no object " + std::to_string(object));
        w.destruction.remove(w.world, {object});
    });
}

brittle_status brittle_world_strike(brittle_world* world, uint32_t piece, const float* point, const float* direction,
                                    double energy, uint32_t* broke, brittle_error* error) {
    return guarded(error, [&] {
        brittle_world& w = need(world, "world");
        const glm::vec3 at = c::read_vector(point, "point");
        const glm::vec3 along = c::read_vector(direction, "direction");
        const float length = glm::length(along);
        if (!(length > 0.0f && std::isfinite(length))) refuse("direction has no length, or one beyond a float");
        c::in_range(energy, 1e-30, 1e30, "energy");
        if (!w.destruction.contains({piece})) refuse("there is no piece " + std::to_string(piece));
        const double impulse = std::sqrt(2.0 * energy); // N s, of one kilogram
        const std::optional<uint32_t> bonded = w.destruction.bonded({piece});
        if (physics::Structure* structure = w.destruction.structure(w.destruction.object({piece})); structure && bonded)
            structure->blow(w.world, *bonded, along / length * static_cast<float>(impulse));
        const bool breaks = w.destruction.strike(w.world, {piece}, at, along / length, energy,
                                                 impulse / static_cast<double>(physics::impact_seconds));
        if (broke) *broke = breaks;
    });
}

brittle_status brittle_world_shoot(brittle_world* world, const float* from, const float* velocity, float radius,
                                   float density, uint32_t* body, brittle_error* error) {
    return guarded(error, [&] {
        brittle_world& w = need(world, "world");
        const glm::vec3 at = c::read_vector(from, "from"), speed = c::read_vector(velocity, "velocity");
        c::in_range(static_cast<double>(radius), 1e-6, 1e6, "radius");
        c::in_range(static_cast<double>(density), 1e-6, 1e9, "density");
        const physics::BodyId id = must(w.world.add_body(c::ball(at, speed, radius, density)));
        if (body) *body = id.value;
    });
}

brittle_status brittle_world_body(const brittle_world* world, uint32_t body, float* position, float* orientation,
                                  brittle_error* error) {
    return guarded(error, [&] {
        const brittle_world& w = need(world, "world");
        need(position, "position");
        need(orientation, "orientation");
        if (!w.world.contains({body})) refuse("there is no body " + std::to_string(body));
        c::put(w.world.pose({body}), position, orientation);
    });
}

brittle_status brittle_world_step(brittle_world* world, uint32_t steps, brittle_error* error) {
    return guarded(error, [&] {
        brittle_world& w = need(world, "world");
        for (uint32_t k = 0; k < steps; ++k) {
            w.world.step();
            w.destruction.update(w.world);
        }
    });
}

brittle_status brittle_world_state_hash(const brittle_world* world, uint64_t* out, brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        const brittle_world& w = need(world, "world");
        constexpr uint64_t fnv_prime = 1099511628211ull;
        *out = (w.world.state_hash() * fnv_prime) ^ w.destruction.state_hash();
    });
}

brittle_status brittle_world_transforms(const brittle_world* world, float alpha, brittle_transform* out,
                                        uint64_t capacity, uint64_t* count, brittle_error* error) {
    return guarded(error, [&] {
        const brittle_world& w = need(world, "world");
        c::in_range(static_cast<double>(alpha), 0.0, 1.0, "alpha");
        c::Transforms transforms(w.destruction, out, capacity);
        w.destruction.visit_poses(w.world, alpha, 0,
                                  [&](uint32_t slot, const physics::Pose& pose) { transforms.add(slot, pose); });
        if (count) *count = transforms.count();
    });
}

brittle_status brittle_world_events(brittle_world* world, brittle_events** out, brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        *out = c::events_of(need(world, "world").destruction.take_events());
    });
}

} // extern "C"
