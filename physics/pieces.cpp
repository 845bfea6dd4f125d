#include "physics/pieces.h"

#include <string>
#include <utility>

#include <glm/geometric.hpp>

#include "physics/crowd.h"
#include "physics/piece_mass.h"
#include "physics/world_check.h"

namespace brittle::physics {

namespace {

using fracture::Error;
using fracture::Fragments;
using fracture::Piece;
using fracture::Status;

void give(BodyDesc& body, const BodyMass& mass) {
    body.mass = static_cast<float>(mass.mass);
    body.inertia = glm::mat3(mass.inertia);
}

void describe(BodyDesc& body, const Piece& piece, const Material& material, const PlacedMotion& motion) {
    const glm::dvec3 arm = glm::dquat(motion.placement.orientation) * piece.mass.centre_of_mass;
    body.pose = {glm::vec3(glm::dvec3(motion.placement.position) + arm), motion.placement.orientation};
    body.linear_velocity = motion.linear_velocity + glm::cross(motion.angular_velocity, glm::vec3(arm));
    body.angular_velocity = motion.angular_velocity;
    body.friction = material.friction;
    body.restitution = material.restitution;
    give(body, true_mass(piece, material.density));
}

// A sliver's integrals can round to a volume or a tensor that no body has: it gets those of a box.
Result<void> replace_impossible_masses(std::span<BodyDesc> bodies, const Fragments& fragments, const Material& material) {
    fracture::PrincipalAxes principal;
    for (size_t i = 0; i < bodies.size(); ++i) {
        if (fault_of(bodies[i], principal).empty()) continue;
        give(bodies[i], box_mass(fragments.positions_of(fragments.pieces[i]), material.density));
        if (const std::string fault = fault_of(bodies[i], principal); !fault.empty())
            return Error{Status::invalid_setting, "piece " + std::to_string(i) + " cannot become a body: " + fault};
    }
    return {};
}

std::vector<Newcomer> newcomers(const Fragments& fragments) {
    std::vector<Newcomer> batch;
    batch.reserve(fragments.pieces.size());
    for (const Piece& piece : fragments.pieces) batch.push_back({.size = piece.mass.volume});
    return batch;
}

} // namespace

Result<std::vector<BodyId>> add_pieces(World& world, const Fragments& fragments, const Material& material,
                                       const PlacedMotion& motion, const HullSettings& hull) {
    if (const Result<void> checked = check_pieces(fragments, material); !checked) return checked.error();
    return add_pieces(world, fragments, material, motion, collision_hulls(fragments, hull));
}

Result<std::vector<BodyId>> add_pieces(World& world, const Fragments& fragments, const Material& material,
                                       const PlacedMotion& motion, const PieceHulls& hulls) {
    if (const Result<void> checked = check_pieces(fragments, material); !checked) return checked.error();
    if (hulls.size() != fragments.pieces.size())
        return Error{Status::invalid_setting, std::to_string(hulls.size()) + " hulls were given for "
                                                  + std::to_string(fragments.pieces.size()) + " pieces"};
    std::vector<BodyDesc> bodies(fragments.pieces.size());
    const uint32_t siblings = world.new_siblings();
    const std::vector<uint8_t> debris = crowded_out(newcomers(fragments), room_in(world));
    for (size_t i = 0; i < bodies.size(); ++i) {
        bodies[i].parts = {{hulls[i], glm::vec3(0.0f)}};
        bodies[i].siblings = siblings;
        bodies[i].debris = debris[i] != 0;
        describe(bodies[i], fragments.pieces[i], material, motion);
    }
    // The world is the judge of masses, and nearly always takes them as they are.
    if (Result<std::vector<BodyId>> added = world.add_bodies(bodies)) return added;
    if (const Result<void> replaced = replace_impossible_masses(bodies, fragments, material); !replaced) return replaced.error();
    return world.add_bodies(bodies);
}

} // namespace brittle::physics
