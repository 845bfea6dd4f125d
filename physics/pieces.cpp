#include "physics/pieces.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace brittle::physics {

namespace {

using fracture::Error;
using fracture::Fragments;
using fracture::Piece;
using fracture::Status;

// Least extent of the box that stands in for a piece without volume: as a ratio of its longest, and in
// metres.
constexpr double box_least_ratio = 1e-3;
constexpr double box_least_extent = 1e-4;

bool finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

struct BodyMass {
    double mass = 0.0;
    glm::dmat3 inertia{0.0};
};

BodyMass true_mass(const Piece& piece, double density) {
    return {density * piece.mass.volume, piece.mass.inertia * density};
}

BodyMass box_mass(std::span<const glm::dvec3> points, double density) {
    glm::dvec3 low(0.0), high(0.0);
    for (size_t i = 0; i < points.size(); ++i) {
        low = i == 0 ? points[0] : glm::min(low, points[i]);
        high = i == 0 ? points[0] : glm::max(high, points[i]);
    }
    glm::dvec3 size = high - low;
    const double longest = std::max({size.x, size.y, size.z});
    size = glm::max(size, glm::dvec3(std::max(longest * box_least_ratio, box_least_extent)));
    const double mass = density * size.x * size.y * size.z;
    const glm::dvec3 square = size * size;
    glm::dmat3 inertia(0.0);
    inertia[0][0] = mass / 12.0 * (square.y + square.z);
    inertia[1][1] = mass / 12.0 * (square.x + square.z);
    inertia[2][2] = mass / 12.0 * (square.x + square.y);
    return {mass, inertia};
}

Result<void> check(const Fragments& fragments, const Material& material) {
    if (!(material.density > 0.0f) || !std::isfinite(material.density)) {
        std::ostringstream text;
        text << "the material's density is " << material.density << " kg/m^3; it must be positive";
        return Error{Status::invalid_setting, text.str()};
    }
    for (size_t i = 0; i < fragments.pieces.size(); ++i) {
        const Piece& piece = fragments.pieces[i];
        std::ostringstream text;
        text << "piece " << i << " cannot become a body: ";
        if (piece.vertices.begin > piece.vertices.end || piece.vertices.end > fragments.positions.size()) {
            text << "its vertices " << piece.vertices.begin << " to " << piece.vertices.end
                 << " reach outside the " << fragments.positions.size() << " positions";
            return Error{Status::invalid_mesh, text.str()};
        }
        if (!finite(piece.mass.centre_of_mass)) {
            text << "its centre of mass is not finite";
            return Error{Status::invalid_mesh, text.str()};
        }
        for (uint32_t v = piece.vertices.begin; v < piece.vertices.end; ++v) {
            if (finite(fragments.positions[v])) continue;
            text << "vertex " << v << " is not finite";
            return Error{Status::invalid_mesh, text.str()};
        }
    }
    return {};
}

Result<BodyId> add_piece(World& world, const Fragments& fragments, const Piece& piece,
                         const Material& material, const PlacedMotion& motion, const HullSettings& hull) {
    const glm::dvec3 arm = glm::dquat(motion.placement.orientation) * piece.mass.centre_of_mass;
    BodyDesc desc;
    desc.hull = collision_hull(fragments.positions_of(piece), piece.mass.centre_of_mass, hull);
    desc.pose = {glm::vec3(glm::dvec3(motion.placement.position) + arm), motion.placement.orientation};
    desc.linear_velocity = motion.linear_velocity + glm::cross(motion.angular_velocity, glm::vec3(arm));
    desc.angular_velocity = motion.angular_velocity;
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

} // namespace

Result<std::vector<BodyId>> add_pieces(World& world, const Fragments& fragments, const Material& material,
                                       const PlacedMotion& motion, const HullSettings& hull) {
    if (const Result<void> checked = check(fragments, material); !checked) return checked.error();
    std::vector<BodyId> bodies;
    bodies.reserve(fragments.pieces.size());
    for (size_t i = 0; i < fragments.pieces.size(); ++i) {
        const Result<BodyId> body = add_piece(world, fragments, fragments.pieces[i], material, motion, hull);
        if (!body) {
            for (const BodyId added : bodies) world.remove_body(added);
            return Error{body.error().status, "piece " + std::to_string(i) + ": " + body.error().message};
        }
        bodies.push_back(*body);
    }
    return bodies;
}

} // namespace brittle::physics
