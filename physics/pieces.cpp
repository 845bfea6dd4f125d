#include "physics/pieces.h"

#include <string>
#include <utility>

#include <glm/geometric.hpp>

#include "physics/crowd.h"
#include "physics/piece_mass.h"

namespace brittle::physics {

namespace {

using fracture::Error;
using fracture::Fragments;
using fracture::Piece;
using fracture::Status;

Result<BodyId> add_piece(World& world, const Fragments& fragments, const Piece& piece,
                         const Material& material, const PlacedMotion& motion,
                         const std::shared_ptr<const CollisionHull>& hull, uint32_t siblings, bool debris) {
    const glm::dvec3 arm = glm::dquat(motion.placement.orientation) * piece.mass.centre_of_mass;
    BodyDesc desc;
    desc.parts = {{hull, glm::vec3(0.0f)}};
    desc.pose = {glm::vec3(glm::dvec3(motion.placement.position) + arm), motion.placement.orientation};
    desc.linear_velocity = motion.linear_velocity + glm::cross(motion.angular_velocity, glm::vec3(arm));
    desc.angular_velocity = motion.angular_velocity;
    desc.siblings = siblings;
    desc.debris = debris;
    desc.friction = material.friction;
    desc.restitution = material.restitution;
    // A sliver's integrals can round to a volume or a tensor that no body has; the world is the judge of
    // that.
    const BodyMass exact = true_mass(piece, material.density);
    desc.mass = static_cast<float>(exact.mass);
    desc.inertia = glm::mat3(exact.inertia);
    if (Result<BodyId> body = world.add_body(desc)) return body;
    const BodyMass box = box_mass(fragments.positions_of(piece), material.density);
    desc.mass = static_cast<float>(box.mass);
    desc.inertia = glm::mat3(box.inertia);
    return world.add_body(desc);
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
    std::vector<BodyId> bodies;
    bodies.reserve(fragments.pieces.size());
    const uint32_t siblings = world.new_siblings();
    const std::vector<uint8_t> debris = crowded_out(newcomers(fragments), room_in(world));
    for (size_t i = 0; i < fragments.pieces.size(); ++i) {
        const Result<BodyId> body =
            add_piece(world, fragments, fragments.pieces[i], material, motion, hulls[i], siblings, debris[i]);
        if (!body) {
            for (const BodyId added : bodies) world.remove_body(added);
            return Error{body.error().status, "piece " + std::to_string(i) + ": " + body.error().message};
        }
        bodies.push_back(*body);
    }
    return bodies;
}

} // namespace brittle::physics
