#include "tools/bench/overlap.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/base/random.h"
#include "fracture/mesh/convex_hull.h"
#include "fracture/mesh/mass_properties.h"

namespace brittle::tools {

namespace {

// Sine of the angle below which two directions count as one. A parallel pair of edges adds no axis of its own.
constexpr double same_direction = 1e-6;

void add_direction(std::vector<glm::dvec3>& directions, const glm::dvec3& direction, bool either_sign) {
    const bool known = std::ranges::any_of(directions, [&](const glm::dvec3& other) {
        return glm::length(glm::cross(other, direction)) < same_direction
               && (either_sign || glm::dot(other, direction) > 0.0);
    });
    if (!known) directions.push_back(direction);
}

struct Placed {
    std::vector<glm::dvec3> points, normals, edges;
};

Placed placed(const HullFeatures& hull, const physics::Pose& pose) {
    const glm::dquat turn = glm::normalize(glm::dquat(pose.orientation));
    Placed result;
    for (const glm::dvec3& point : hull.points) result.points.push_back(glm::dvec3(pose.position) + turn * point);
    for (const glm::dvec3& normal : hull.normals) result.normals.push_back(turn * normal);
    for (const glm::dvec3& edge : hull.edges) result.edges.push_back(turn * edge);
    return result;
}

// Of the points along an axis.
double lowest(std::span<const glm::dvec3> points, const glm::dvec3& axis) {
    double result = std::numeric_limits<double>::infinity();
    for (const glm::dvec3& point : points) result = std::min(result, glm::dot(point, axis));
    return result;
}

// The gap between a and b along an axis: b above a.
double gap(const Placed& a, const Placed& b, const glm::dvec3& axis) {
    return lowest(b.points, axis) + lowest(a.points, -axis);
}

bool contains(const HullFeatures& hull, const glm::dvec3& at) {
    for (size_t face = 0; face < hull.normals.size(); ++face)
        if (glm::dot(hull.normals[face], at) > hull.offsets[face]) return false;
    return true;
}

} // namespace

HullFeatures features_of(const physics::CollisionHull& hull) {
    HullFeatures features{.margin = static_cast<double>(hull.margin)};
    for (const glm::vec3& point : hull.points) {
        features.points.emplace_back(point);
        features.radius = std::max(features.radius, glm::length(glm::dvec3(point)));
    }
    features.radius += features.margin;
    const fracture::TriangleMesh mesh = fracture::convex_hull(hull.points);
    features.volume = fracture::signed_volume(mesh.positions, mesh.triangles);
    for (const fracture::Triangle& triangle : mesh.triangles) {
        const glm::dvec3 &a = mesh.positions[triangle.x], &b = mesh.positions[triangle.y],
                         &c = mesh.positions[triangle.z];
        const glm::dvec3 normal = glm::cross(b - a, c - a);
        if (glm::length(normal) > 0.0) add_direction(features.normals, glm::normalize(normal), false);
        for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
            if (from != to) add_direction(features.edges, glm::normalize(to - from), true);
    }
    for (const glm::dvec3& normal : features.normals)
        features.offsets.push_back(features.margin - lowest(features.points, -normal));
    return features;
}

double overlap(const HullFeatures& a, const physics::Pose& pose_a, const HullFeatures& b, const physics::Pose& pose_b) {
    const Placed at_a = placed(a, pose_a), at_b = placed(b, pose_b);
    double most = -std::numeric_limits<double>::infinity(); // gap
    for (const glm::dvec3& normal : at_a.normals) most = std::max(most, gap(at_a, at_b, normal));
    for (const glm::dvec3& normal : at_b.normals) most = std::max(most, gap(at_b, at_a, normal));
    const double margins = a.margin + b.margin;
    for (const glm::dvec3& edge_a : at_a.edges)
        for (const glm::dvec3& edge_b : at_b.edges) {
            if (most > margins) return margins - most; // they do not touch
            const glm::dvec3 across = glm::cross(edge_a, edge_b);
            const double sine = glm::length(across);
            if (sine < same_direction) continue;
            most = std::max({most, gap(at_a, at_b, across / sine), gap(at_b, at_a, across / sine)});
        }
    return margins - most;
}

std::vector<double> overlaps(std::span<const HullFeatures> hulls, std::span<const physics::Pose> poses) {
    std::vector<double> depths;
    for (size_t i = 0; i < poses.size(); ++i)
        for (size_t j = i + 1; j < poses.size(); ++j) {
            const double reach = hulls[i].radius + hulls[j].radius;
            if (glm::length(glm::dvec3(poses[i].position) - glm::dvec3(poses[j].position)) > reach) continue;
            const double depth = overlap(hulls[i], poses[i], hulls[j], poses[j]);
            if (depth > 0.0) depths.push_back(depth);
        }
    return depths;
}

std::vector<double> shares_inside(std::span<const HullFeatures> hulls, std::span<const physics::Pose> poses) {
    constexpr size_t samples = 64;
    std::vector<std::vector<glm::dvec3>> inner; // by hull, world coordinates
    fracture::Random random(1);
    for (size_t i = 0; i < hulls.size(); ++i) {
        fracture::Box box{hulls[i].points[0], hulls[i].points[0]};
        for (const glm::dvec3& point : hulls[i].points)
            box.min = glm::min(box.min, point), box.max = glm::max(box.max, point);
        const glm::dquat turn = glm::normalize(glm::dquat(poses[i].orientation));
        std::vector<glm::dvec3>& points = inner.emplace_back();
        for (int draw = 0; draw < 10'000 && points.size() < samples; ++draw)
            if (const glm::dvec3 at = random.uniform_in(box); contains(hulls[i], at))
                points.push_back(glm::dvec3(poses[i].position) + turn * at);
    }
    std::vector<double> shares(hulls.size(), 0.0);
    for (size_t i = 0; i < hulls.size(); ++i)
        for (size_t j = i + 1; j < hulls.size(); ++j) {
            const glm::dvec3 way = glm::dvec3(poses[i].position) - glm::dvec3(poses[j].position);
            const double reach = hulls[i].radius + hulls[j].radius;
            if (glm::dot(way, way) > reach * reach || inner[i].empty() || inner[j].empty()) continue;
            const bool first = hulls[i].volume <= hulls[j].volume;
            const size_t small = first ? i : j, large = first ? j : i;
            const glm::dquat back = glm::conjugate(glm::normalize(glm::dquat(poses[large].orientation)));
            const auto within = std::ranges::count_if(inner[small], [&](const glm::dvec3& at) {
                return contains(hulls[large], back * (at - glm::dvec3(poses[large].position)));
            });
            shares[small] =
                std::max(shares[small], static_cast<double>(within) / static_cast<double>(inner[small].size()));
        }
    return shares;
}

} // namespace brittle::tools
