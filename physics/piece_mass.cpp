#include "physics/piece_mass.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include <glm/common.hpp>

#include "fracture/principal_axes.h"

namespace brittle::physics {

namespace {

using fracture::Error;
using fracture::Fragments;
using fracture::Piece;
using fracture::Result;
using fracture::Status;

// Least extent of the box that stands in for a piece without volume: as a ratio of its longest, and in
// metres.
constexpr double box_least_ratio = 1e-3;
constexpr double box_least_extent = 1e-4;

// Slack for "none above the sum of the other two", as in world.cpp.
constexpr double moment_slack = 1e-3;

bool finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

} // namespace

Result<void> check_pieces(const Fragments& fragments, const Material& material) {
    if (std::string fault = fault_of(material); !fault.empty())
        return Error{Status::invalid_setting, std::move(fault)};
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

BodyMass true_mass(const Piece& piece, double density) {
    return {density * piece.mass.volume, piece.mass.inertia * density};
}

bool is_possible(const BodyMass& body) {
    if (!(body.mass > 0.0) || !std::isfinite(body.mass)) return false;
    const glm::dvec3 moments = fracture::principal_axes(body.inertia).moments;
    const double largest = std::max({moments.x, moments.y, moments.z});
    const double smallest = std::min({moments.x, moments.y, moments.z});
    return largest > 0.0 && smallest >= -moment_slack * largest
           && 2.0 * largest <= (moments.x + moments.y + moments.z) * (1.0 + moment_slack);
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

BodyMass piece_mass(const Fragments& fragments, const Piece& piece, double density) {
    const BodyMass exact = true_mass(piece, density);
    return is_possible(exact) ? exact : box_mass(fragments.positions_of(piece), density);
}

} // namespace brittle::physics
