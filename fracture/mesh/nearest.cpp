#include "fracture/mesh/nearest.h"

#include <algorithm>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>

namespace brittle::fracture {

namespace {

// Squared sine of the angle at a, below which a triangle is treated as its edges: rounding exceeds its width.
constexpr double thin = 1e-8;

glm::dvec3 nearest_on_segment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
    const glm::dvec3 ab = b - a;
    const double square = glm::dot(ab, ab);
    return square > 0.0 ? a + std::clamp(glm::dot(p - a, ab) / square, 0.0, 1.0) * ab : a;
}

glm::dvec3 nearest_on_edges(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const auto apart = [&](const glm::dvec3& on) { return glm::dot(on - p, on - p); };
    const auto nearer = [&](const glm::dvec3& x, const glm::dvec3& y) { return apart(y) < apart(x) ? y : x; };
    return nearer(nearer(nearest_on_segment(p, a, b), nearest_on_segment(p, b, c)), nearest_on_segment(p, c, a));
}

} // namespace

// Classifies the projected point by Voronoi region of the triangle (Ericson, "Real-Time Collision Detection", 5.1.5).
glm::dvec3 nearest_on_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const glm::dvec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const glm::dvec3 normal = glm::cross(ab, ac);
    if (glm::dot(normal, normal) <= thin * glm::dot(ab, ab) * glm::dot(ac, ac)) return nearest_on_edges(p, a, b, c);
    const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
    if (d1 <= 0.0 && d2 <= 0.0) return a;
    const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
    if (d3 >= 0.0 && d4 <= d3) return b;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + ab * (d1 / (d1 - d3));
    const double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d6 >= 0.0 && d5 <= d6) return c;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + ac * (d2 / (d2 - d6));
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0.0 && d4 >= d3 && d5 >= d6) return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    const double sum = va + vb + vc;
    return a + ab * (vb / sum) + ac * (vc / sum);
}

glm::dvec3 nearest_on(const TriangleMesh& mesh, const glm::dvec3& point) {
    glm::dvec3 nearest = point;
    double least = std::numeric_limits<double>::infinity();
    for (const Triangle& t : mesh.triangles) {
        const glm::dvec3 on = nearest_on_triangle(point, mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]);
        const glm::dvec3 apart = on - point;
        if (const double square = glm::dot(apart, apart); square < least) {
            least = square;
            nearest = on;
        }
    }
    return nearest;
}

double distance_to_hull(std::span<const glm::vec3> points, const glm::dvec3& point) {
    constexpr int max_steps = 200;     // usual hulls converge in a few dozen
    constexpr double precision = 1e-3; // relative to the distance, and to the farthest point's distance near the hull
    double farthest_distance = 0.0;
    for (const glm::vec3& corner : points)
        farthest_distance = std::max(farthest_distance, glm::distance(glm::dvec3(corner), point));
    const double near = precision * precision * farthest_distance * farthest_distance;
    std::vector<double> weights(points.size(), 0.0);
    weights[0] = 1.0;
    glm::dvec3 apart = glm::dvec3(points[0]) - point;
    for (int step = 0; step < max_steps; ++step) {
        const auto ahead = [&](size_t i) { return glm::dot(apart, glm::dvec3(points[i]) - point); };
        // Along the direction to the query point; farthest among the points with weight.
        size_t nearest = 0, farthest = points.size();
        for (size_t i = 0; i < points.size(); ++i) {
            if (ahead(i) < ahead(nearest)) nearest = i;
            if (weights[i] > 0.0 && (farthest == points.size() || ahead(i) > ahead(farthest))) farthest = i;
        }
        // ahead(nearest) / |apart| is a lower bound of the distance to the hull.
        const double square = glm::dot(apart, apart);
        if (square <= near || square - ahead(nearest) <= precision * square) break;
        const glm::dvec3 way = glm::dvec3(points[nearest]) - glm::dvec3(points[farthest]);
        const double moved = std::clamp(-glm::dot(apart, way) / glm::dot(way, way), 0.0, weights[farthest]);
        weights[nearest] += moved;
        weights[farthest] = moved < weights[farthest] ? weights[farthest] - moved : 0.0;
        apart += moved * way;
    }
    return glm::length(apart);
}

} // namespace brittle::fracture
