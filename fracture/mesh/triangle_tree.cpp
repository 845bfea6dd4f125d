#include "fracture/mesh/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/mesh/nearest.h"

namespace brittle::fracture {

namespace {

constexpr uint32_t leaf_size = 4;
constexpr double infinity = std::numeric_limits<double>::infinity();

// Returns the ray parameter of the hit, infinity for a miss (Moeller and Trumbore, "Fast, minimum storage ray-triangle
// intersection", 1997).
double distance_to(const glm::dvec3& origin, const glm::dvec3& direction, const glm::dvec3& a, const glm::dvec3& b,
                   const glm::dvec3& c) {
    const glm::dvec3 u = b - a, v = c - a, across = glm::cross(direction, v);
    const double determinant = glm::dot(u, across);
    if (determinant == 0.0) return infinity;
    const glm::dvec3 from = origin - a, turned = glm::cross(from, u);
    const double s = glm::dot(from, across) / determinant, t = glm::dot(direction, turned) / determinant;
    if (!(s >= 0.0) || !(t >= 0.0) || !(s + t <= 1.0)) return infinity;
    return glm::dot(v, turned) / determinant;
}

} // namespace

TriangleTree::TriangleTree(const TriangleMesh& mesh, std::vector<uint32_t> triangles)
    : mesh_(mesh), order_(std::move(triangles)) {
    nodes_.reserve(order_.size());
    if (!order_.empty()) root_ = build(0, static_cast<uint32_t>(order_.size()));
}

// Splits at the median, so the depth is the logarithm of the count.
uint32_t TriangleTree::build(uint32_t begin, uint32_t end) {
    Node node{glm::dvec3(infinity), glm::dvec3(-infinity), begin, end};
    for (uint32_t k = begin; k < end; ++k)
        for (int c = 0; c < 3; ++c) {
            const glm::dvec3& p = mesh_.positions[mesh_.triangles[order_[k]][c]];
            node.min = glm::min(node.min, p);
            node.max = glm::max(node.max, p);
        }
    if (end - begin > leaf_size) {
        const glm::dvec3 size = node.max - node.min;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
        const auto middle = [&](uint32_t t) {
            const Triangle& c = mesh_.triangles[t];
            return mesh_.positions[c.x][axis] + mesh_.positions[c.y][axis] + mesh_.positions[c.z][axis];
        };
        const uint32_t half = begin + (end - begin) / 2;
        std::nth_element(order_.begin() + begin, order_.begin() + half, order_.begin() + end,
                         [&](uint32_t x, uint32_t y) {
                             const double a = middle(x), b = middle(y);
                             return a != b ? a < b : x < y;
                         });
        node.low = build(begin, half);
        node.high = build(half, end);
    }
    nodes_.push_back(node);
    return static_cast<uint32_t>(nodes_.size() - 1);
}

std::optional<double> TriangleTree::first_hit(const glm::dvec3& origin, const glm::dvec3& direction, uint32_t excluded,
                                              uint64_t* visits) const {
    if (root_ == no_index) return std::nullopt;
    const glm::dvec3 inverse = 1.0 / direction; // infinite along an axis with a zero component
    double nearest = infinity;
    // The ray parameter at which the ray enters the box; infinity where it misses it or enters behind the nearest hit.
    const auto entry = [&](const Node& node) {
        double from = 0.0, to = nearest;
        for (int k = 0; k < 3; ++k) {
            double near = (node.min[k] - origin[k]) * inverse[k], far = (node.max[k] - origin[k]) * inverse[k];
            if (near > far) std::swap(near, far);
            if (near > from) from = near; // a NaN from 0 x infinity is ignored
            if (far < to) to = far;
        }
        return from <= to * (1.0 + 1e-12) ? from : infinity;
    };
    struct Visit {
        uint32_t node;
        double entry;
    };
    std::array<Visit, 128> stack; // at most depth + 1 nodes wait here, 33 for 2^32 triangles
    size_t size = 0;
    stack[size++] = {root_, entry(nodes_[root_])};
    while (size > 0) {
        const Visit visit = stack[--size];
        if (!(visit.entry <= nearest * (1.0 + 1e-12)) || visit.entry == infinity) continue;
        const Node& node = nodes_[visit.node];
        if (visits) ++*visits;
        if (node.low != no_index) { // the nearer child comes first, so that its hits spare the other
            Visit near{node.low, entry(nodes_[node.low])}, far{node.high, entry(nodes_[node.high])};
            if (far.entry < near.entry) std::swap(near, far);
            stack[size++] = far;
            stack[size++] = near;
            continue;
        }
        for (uint32_t k = node.begin; k < node.end; ++k) {
            if (order_[k] == excluded) continue;
            const Triangle& t = mesh_.triangles[order_[k]];
            const double at =
                distance_to(origin, direction, mesh_.positions[t.x], mesh_.positions[t.y], mesh_.positions[t.z]);
            if (at > 0.0 && at < nearest) nearest = at;
        }
    }
    return nearest < infinity ? std::optional(nearest) : std::nullopt;
}

double TriangleTree::distance(const glm::dvec3& point) const {
    const auto squared = [&](const glm::dvec3& q) { return glm::dot(q - point, q - point); };
    const auto to_box = [&](uint32_t node) { return squared(glm::clamp(point, nodes_[node].min, nodes_[node].max)); };
    double nearest = infinity; // squared
    struct Visit {
        uint32_t node;
        double squared;
    };
    std::array<Visit, 128> stack; // at most depth + 1 nodes wait here
    size_t size = 0;
    if (root_ != no_index) stack[size++] = {root_, to_box(root_)};
    while (size > 0) {
        const Visit visit = stack[--size];
        if (!(visit.squared < nearest)) continue;
        const Node& node = nodes_[visit.node];
        if (node.low != no_index) {
            Visit near{node.low, to_box(node.low)}, far{node.high, to_box(node.high)};
            if (far.squared < near.squared) std::swap(near, far);
            stack[size++] = far;
            stack[size++] = near;
            continue;
        }
        for (uint32_t k = node.begin; k < node.end; ++k) {
            const Triangle& t = mesh_.triangles[order_[k]];
            nearest = std::min(nearest, squared(nearest_on_triangle(point, mesh_.positions[t.x], mesh_.positions[t.y],
                                                                    mesh_.positions[t.z])));
        }
    }
    return std::sqrt(nearest);
}

std::optional<double> first_hit(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
                                const glm::dvec3& origin, const glm::dvec3& direction) {
    double nearest = infinity;
    for (const Triangle& t : triangles) {
        const double at = distance_to(origin, direction, positions[t.x], positions[t.y], positions[t.z]);
        if (at > 0.0 && at < nearest) nearest = at;
    }
    return nearest < infinity ? std::optional(nearest) : std::nullopt;
}

} // namespace brittle::fracture
