#include "physics/world/piece_mass.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <glm/common.hpp>

#include "fracture/mesh/principal_axes.h"

namespace brittle::physics {

namespace {

using fracture::Error;
using fracture::Fragments;
using fracture::Piece;
using fracture::Result;
using fracture::Status;

// Smallest extent of the box that replaces a piece without volume: as a ratio of its longest, and in metres.
constexpr double min_box_ratio = 1e-3;
constexpr double min_box_extent = 1e-4;

bool finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Returns whether all points are finite. x - x is 0 or NaN, which avoids a branch per point; two sums shorten the
// dependency chain.
bool finite(std::span<const glm::dvec3> points) {
    glm::dvec3 even(0.0), odd(0.0); // 0 or NaN
    for (size_t i = 1; i < points.size(); i += 2) {
        even += points[i - 1] - points[i - 1];
        odd += points[i] - points[i];
    }
    if (points.size() % 2 != 0) odd += points.back() - points.back();
    return even + odd == glm::dvec3(0.0);
}

std::string fault_of(const Fragments& fragments, const Piece& piece) {
    const fracture::Range& own = piece.vertices;
    if (own.begin > own.end || own.end > fragments.positions.size())
        return "its vertices " + std::to_string(own.begin) + " to " + std::to_string(own.end) + " reach outside the "
               + std::to_string(fragments.positions.size()) + " positions";
    if (!finite(piece.mass.centre_of_mass)) return "its centre of mass is not finite";
    if (finite(fragments.positions_of(piece))) return {};
    uint32_t vertex = own.begin;
    while (finite(fragments.positions[vertex])) ++vertex;
    return "vertex " + std::to_string(vertex) + " is not finite";
}

} // namespace

Result<void> check_pieces(const Fragments& fragments, const Material& material) {
    if (std::string fault = fault_of(material); !fault.empty()) return Error{Status::invalid_setting, std::move(fault)};
    for (size_t i = 0; i < fragments.pieces.size(); ++i)
        if (const std::string fault = fault_of(fragments, fragments.pieces[i]); !fault.empty())
            return Error{Status::invalid_mesh, "piece " + std::to_string(i) + " cannot become a body: " + fault};
    return {};
}

BodyMass true_mass(const Piece& piece, double density) {
    return {density * piece.mass.volume, piece.mass.inertia * density};
}

bool is_possible(const BodyMass& body) {
    if (!(body.mass >= static_cast<double>(min_mass)) || !std::isfinite(body.mass)) return false;
    const glm::dvec3 moments = fracture::principal_axes(body.inertia).moments;
    const double largest = std::max({moments.x, moments.y, moments.z});
    const double smallest = std::min({moments.x, moments.y, moments.z});
    return largest >= min_moment && smallest >= -moment_slack * largest
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
    size = glm::max(size, glm::dvec3(std::max(longest * min_box_ratio, min_box_extent)));
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
