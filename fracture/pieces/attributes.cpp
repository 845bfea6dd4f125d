#include "fracture/pieces/attributes.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace brittle::fracture {

namespace {

constexpr uint32_t first_cut_point = 1u << 30; // see Fragments::vertex_point

// The weight below which a point lies on the opposite side, up to rounding.
constexpr double min_weight = 1e-12;

// The cosine of the angle between a cut and the bisector of the two sites above which the cut lies on the bisector. A
// merged piece keeps only one of its sites, so it has cuts on other bisectors.
constexpr double same_plane = 0.99999;

glm::dvec3 along_longest_side(const glm::dvec3& p, const std::array<glm::dvec3, 3>& corners) {
    size_t from = 0;
    double longest = -1.0;
    for (size_t k = 0; k < 3; ++k) {
        const double length = glm::distance(corners[k], corners[(k + 1) % 3]);
        if (length > longest) {
            longest = length;
            from = k;
        }
    }
    const size_t to = (from + 1) % 3;
    glm::dvec3 weights(0.0);
    const double t =
        longest > 0.0
            ? std::clamp(glm::dot(p - corners[from], corners[to] - corners[from]) / (longest * longest), 0.0, 1.0)
            : 0.0;
    weights[static_cast<int>(from)] = 1.0 - t;
    weights[static_cast<int>(to)] = t;
    return weights;
}

// Returns the unit normal that both sides of a cut share: the first component that is clearly nonzero is positive.
glm::dvec3 without_side(const glm::dvec3& unit) {
    for (int k = 0; k < 3; ++k)
        if (std::abs(unit[k]) >= 1e-6) return unit[k] > 0.0 ? unit : -unit;
    return unit;
}

// Returns a horizontal and an upward axis on the plane with the given unit normal.
std::array<glm::dvec3, 2> axes_on(const glm::dvec3& normal) {
    const bool is_level = std::abs(normal.y) > 0.999;
    const glm::dvec3 up = is_level ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
    const glm::dvec3 u = glm::normalize(glm::cross(up, normal));
    return {u, glm::cross(normal, u)};
}

} // namespace

glm::dvec2 plane_uv(const glm::dvec3& normal, const glm::dvec3& point) {
    const auto [u, v] = axes_on(without_side(normal));
    return {glm::dot(point, u), glm::dot(point, v)};
}

glm::dvec3 barycentrics(const std::array<glm::dvec3, 3>& corners, const glm::dvec3& p) {
    const glm::dvec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const double area2 = glm::dot(normal, normal);
    if (!(area2 > 0.0)) return along_longest_side(p, corners);
    glm::dvec3 weights;
    for (int k = 0; k < 3; ++k) {
        const glm::dvec3 &a = corners[static_cast<size_t>((k + 1) % 3)], &b = corners[static_cast<size_t>((k + 2) % 3)];
        const double weight = glm::dot(glm::cross(a - p, b - p), normal) / area2;
        weights[k] = weight < min_weight ? 0.0 : weight;
    }
    const double sum = weights.x + weights.y + weights.z;
    return std::isfinite(sum) && sum > 0.0 ? weights / sum : along_longest_side(p, corners);
}

std::array<glm::dvec3, 3> barycentrics(const TriangleMesh& source, const Fragments& fragments, const Piece& piece,
                                       uint32_t triangle) {
    const Triangle& of = source.triangles[fragments.triangle_source[triangle]];
    const std::array corners = {source.positions[of.x], source.positions[of.y], source.positions[of.z]};
    std::array<glm::dvec3, 3> result{};
    for (int k = 0; k < 3; ++k) {
        const uint32_t v = piece.vertices.begin + fragments.triangles[triangle][k];
        const uint32_t point = fragments.vertex_point[v];
        glm::dvec3& weights = result[static_cast<size_t>(k)];
        if (point < first_cut_point && (point == of.x || point == of.y || point == of.z)) {
            weights[point == of.x ? 0 : (point == of.y ? 1 : 2)] = 1.0;
        } else {
            weights = barycentrics(corners, fragments.positions[v]);
        }
    }
    return result;
}

std::array<glm::dvec2, 3> interior_uv(std::span<const glm::dvec3> sites, const Fragments& fragments, const Piece& piece,
                                      uint32_t triangle) {
    const uint32_t other = fragments.triangle_source[triangle];
    const glm::dvec3 &low = sites[std::min(piece.site, other)], &high = sites[std::max(piece.site, other)];
    std::array<glm::dvec3, 3> p{};
    for (int k = 0; k < 3; ++k)
        p[static_cast<size_t>(k)] = fragments.positions[piece.vertices.begin + fragments.triangles[triangle][k]];

    glm::dvec3 normal = high - low;
    const double apart = glm::length(normal);
    if (apart > 0.0) normal /= apart;
    glm::dvec3 own = glm::cross(p[1] - p[0], p[2] - p[0]);
    const double area2 = glm::length(own);
    if (area2 > 0.0 && !(std::abs(glm::dot(own, normal)) > same_plane * area2)) {
        normal = without_side(own / area2);
    }
    const auto [u, v] = axes_on(normal);
    const glm::dvec3 middle = 0.5 * low + 0.5 * high;
    std::array<glm::dvec2, 3> result{};
    for (size_t k = 0; k < 3; ++k) result[k] = {glm::dot(p[k] - middle, u), glm::dot(p[k] - middle, v)};
    return result;
}

} // namespace brittle::fracture
