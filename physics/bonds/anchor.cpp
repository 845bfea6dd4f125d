#include "physics/bonds/anchor.h"

#include <algorithm>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/mesh/nearest.h"

namespace brittle::physics {

namespace {

using fracture::Box;
using fracture::Fragments;
using fracture::Piece;
using fracture::Triangle;

bool reaches_box(const Box& box, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const glm::dvec3 half = box.size() * 0.5, centre = box.centre();
    const glm::dvec3 p[3] = {a - centre, b - centre, c - centre};
    const auto apart = [&](const glm::dvec3& axis) {
        const double reach = glm::dot(half, glm::abs(axis));
        const double x = glm::dot(axis, p[0]), y = glm::dot(axis, p[1]), z = glm::dot(axis, p[2]);
        return std::min({x, y, z}) > reach || std::max({x, y, z}) < -reach;
    };
    for (int k = 0; k < 3; ++k) {
        glm::dvec3 axis(0.0);
        axis[k] = 1.0;
        if (apart(axis)) return false;
        for (int edge = 0; edge < 3; ++edge)
            if (apart(glm::cross(axis, p[(edge + 1) % 3] - p[edge]))) return false;
    }
    return !apart(glm::cross(p[1] - p[0], p[2] - p[0]));
}

} // namespace

bool reaches(const AnchorRegion& region, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    if (const Box* box = std::get_if<Box>(&region)) return reaches_box(*box, a, b, c);
    if (const HalfSpace* half = std::get_if<HalfSpace>(&region))
        return std::min({glm::dot(half->normal, a), glm::dot(half->normal, b), glm::dot(half->normal, c)})
               <= half->distance;
    const Ball& ball = std::get<Ball>(region);
    const glm::dvec3 apart = fracture::nearest_on_triangle(ball.centre, a, b, c) - ball.centre;
    return glm::dot(apart, apart) <= ball.radius * ball.radius;
}

bool reaches(std::span<const AnchorRegion> regions, std::span<const glm::dvec3> positions,
             std::span<const Triangle> triangles) {
    return std::ranges::any_of(regions, [&](const AnchorRegion& region) {
        return std::ranges::any_of(triangles, [&](const Triangle& t) {
            return reaches(region, positions[t.x], positions[t.y], positions[t.z]);
        });
    });
}

std::vector<uint32_t> anchor_to(const Fragments& fragments, std::span<const AnchorRegion> regions) {
    return anchor_where(fragments, [&](const Piece& piece) {
        return reaches(regions, fragments.positions_of(piece), fragments.triangles_of(piece));
    });
}

std::vector<uint32_t> anchor_to_ground(const Fragments& fragments, const Pose& placement, float ground, float height) {
    return anchor_where(fragments, [&](const Piece& piece) {
        return std::ranges::any_of(fragments.positions_of(piece), [&](const glm::dvec3& position) {
            return placement.position.y + (glm::dquat(placement.orientation) * position).y <= ground + height;
        });
    });
}

std::vector<uint32_t> anchor_where(const Fragments& fragments, const std::function<bool(const Piece&)>& held) {
    std::vector<uint32_t> anchored;
    for (uint32_t i = 0; i < fragments.pieces.size(); ++i)
        if (held(fragments.pieces[i])) anchored.push_back(i);
    return anchored;
}

} // namespace brittle::physics
