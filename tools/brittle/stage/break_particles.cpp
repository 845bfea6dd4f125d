#include "tools/brittle/stage/break_particles.h"

#include <algorithm>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace brittle::tools {

namespace {

using physics::BodyId;
using physics::Structure;

// By material, chosen by eye: glass splinters and hardly dusts, wood throws long fibres, concrete mostly dust.
struct Habit {
    std::string_view material;
    float splinters, dust, length, width;
    float whiter; // share of white in the dust
};
constexpr Habit habits[] = {{"glass", 1.6f, 0.05f, 1.2f, 0.35f, 0.5f},  {"stone", 1.0f, 1.0f, 1.0f, 0.6f, 0.25f},
                            {"concrete", 0.9f, 1.3f, 1.0f, 0.7f, 0.3f}, {"wood", 1.4f, 0.12f, 2.6f, 0.14f, 0.2f},
                            {"ceramic", 1.3f, 0.3f, 1.0f, 0.45f, 0.4f}, {"brick", 0.9f, 1.1f, 0.9f, 0.7f, 0.2f}};
constexpr Habit habit_without_material{"", 1.0f, 0.7f, 1.0f, 0.6f, 0.35f};

// A number for each place where something breaks, so that a run looks alike whenever it is shown.
uint64_t seed_of(uint64_t step, uint64_t what, uint64_t part) {
    return step * 0x9e3779b97f4a7c15ull ^ what * 0xc2b2ae3d27d4eb4full ^ part * 0x165667b19e3779f9ull;
}

glm::vec3 velocity_at(const physics::World& world, BodyId body, const glm::vec3& at) {
    return world.linear_velocity(body) + glm::cross(world.angular_velocity(body), at - world.pose(body).position);
}

} // namespace

ParticleLook particle_look(const physics::MaterialPreset* material, const engine::SurfaceLook& surface) {
    const Habit* habit = &habit_without_material;
    for (const Habit& one : habits)
        if (material && one.material == material->name) habit = &one;
    return {.splinter_colour = surface.interior,
            .dust_colour = glm::mix(surface.interior, glm::vec3(0.75f), habit->whiter),
            .splinters = habit->splinters,
            .dust = habit->dust,
            .length = habit->length,
            .width = habit->width};
}

void BreakParticles::start(const Simulation& simulation, std::vector<ParticleLook> looks) {
    particles_.clear();
    const std::optional<float> ground = simulation.world().settings().ground_height;
    particles_.set_ground(ground.has_value(), ground.value_or(0.0f));
    looks_ = std::move(looks);
    bonds_.clear();
    steps_ = simulation.steps();
    for (const Structure* structure : simulation.structures()) {
        Bonds& bonds = bonds_[structure];
        for (const physics::BondGraph::Bond& bond : structure->graph().bonds()) bonds.live.push_back(bond.live());
        bonds.object_of.resize(structure->piece_count());
    }
    for (uint32_t piece = 0; piece < simulation.piece_count(); ++piece) note_object(simulation, piece);
}

void BreakParticles::note_object(const Simulation& simulation, uint32_t piece) {
    const auto [structure, index] = simulation.bonds_of(piece);
    if (!structure) return;
    std::vector<uint32_t>& object_of = bonds_[structure].object_of;
    object_of.resize(structure->piece_count());
    object_of[index] = simulation.member_of(piece);
}

ParticleLook BreakParticles::look_of(uint32_t object) const {
    ParticleLook look = object < looks_.size() ? looks_[object] : ParticleLook{};
    look.splinters *= amount_;
    look.dust *= amount_;
    return look;
}

void BreakParticles::advance(const Simulation& simulation) {
    const physics::World& world = simulation.world();
    const Obstacles obstacles = [&](std::span<const Way> ways, std::span<std::optional<Obstacle>> met) {
        find_obstacles(world, ways, met);
    };
    for (; steps_ < simulation.steps(); ++steps_) particles_.step(world.settings().step, obstacles);
    if (amount_ == 0.0f) return;
    for (const Structure* structure : simulation.structures()) watch(simulation, *structure, bonds_[structure]);
}

// Particles know the ground themselves.
void BreakParticles::find_obstacles(const physics::World& world, std::span<const Way> ways,
                                    std::span<std::optional<Obstacle>> met) {
    rays_.clear();
    for (const Way& way : ways) rays_.push_back({way.from, way.to});
    hits_.resize(rays_.size());
    world.cast_rays(rays_, hits_);
    for (size_t k = 0; k < ways.size(); ++k)
        if (hits_[k] && hits_[k]->body != BodyId{})
            met[k] = Obstacle{hits_[k]->point, hits_[k]->normal, velocity_at(world, hits_[k]->body, hits_[k]->point)};
}

void BreakParticles::watch(const Simulation& simulation, const Structure& structure, Bonds& bonds) {
    const auto now = structure.graph().bonds();
    bonds.live.resize(now.size(), true);
    if (bonds.object_of.size() < structure.piece_count()) // parts of pieces that were cut
        for (const physics::PieceId piece : simulation.destruction()->pieces()) note_object(simulation, piece.value);
    bonds.object_of.resize(structure.piece_count());
    for (uint32_t k = 0; k < now.size(); ++k) {
        const physics::BondGraph::Bond& bond = now[k];
        if (bond.live() || !bonds.live[k]) continue;
        bonds.live[k] = false;
        // Half on each side. A side that is gone, or that stands for a fixed object, has no body.
        for (const uint32_t piece : {bond.a, bond.b}) {
            const BodyId body = structure.body_of(piece);
            if (!simulation.world().contains(body)) continue;
            const physics::Pose pose = simulation.world().pose(body);
            const glm::vec3 at = pose.position + pose.orientation * structure.in_body(piece, bond.centroid);
            particles_.burst({.at = at,
                              .normal = pose.orientation * glm::vec3(bond.normal),
                              .velocity = velocity_at(simulation.world(), body, at),
                              .area = 0.5f * static_cast<float>(bond.area)},
                             look_of(bonds.object_of[piece]), seed_of(steps_, k, piece));
        }
    }
}

void BreakParticles::cut(const Simulation& simulation, const physics::PieceAdded& added,
                         std::span<const CrackPoint> cracks) {
    const BodyId body = simulation.body_of(added.id.value);
    if (amount_ == 0.0f || cracks.empty() || body == BodyId{}) return;
    const physics::Pose pose = simulation.pose_of(added.id.value);
    const ParticleLook look = look_of(simulation.member_of(added.object));
    for (uint32_t k = 0; k < cracks.size(); ++k) {
        const glm::vec3 at = pose.position + pose.orientation * cracks[k].at;
        particles_.burst({.at = at,
                          .normal = pose.orientation * cracks[k].normal,
                          .velocity = velocity_at(simulation.world(), body, at),
                          .area = cracks[k].area},
                         look, seed_of(steps_, added.id.value, ~uint64_t{k}));
    }
}

} // namespace brittle::tools
