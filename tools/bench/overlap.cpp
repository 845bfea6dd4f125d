#include "tools/bench/overlap.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

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

} // namespace

HullFeatures features_of(const physics::CollisionHull& hull) {
    HullFeatures features{.margin = static_cast<double>(hull.margin)};
    for (const glm::vec3& point : hull.points) {
        features.points.emplace_back(point);
        features.radius = std::max(features.radius, glm::length(glm::dvec3(point)));
    }
    features.radius += features.margin;
    const fracture::TriangleMesh mesh = physics::hull_mesh(hull.points);
    for (const fracture::Triangle& triangle : mesh.triangles) {
        const glm::dvec3 &a = mesh.positions[triangle.x], &b = mesh.positions[triangle.y],
                         &c = mesh.positions[triangle.z];
        const glm::dvec3 normal = glm::cross(b - a, c - a);
        if (glm::length(normal) > 0.0) add_direction(features.normals, glm::normalize(normal), false);
        for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
            if (from != to) add_direction(features.edges, glm::normalize(to - from), true);
    }
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

} // namespace brittle::tools
