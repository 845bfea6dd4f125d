#include "fracture/local/cluster_queries.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/mesh/nearest.h"

namespace brittle::fracture {

namespace {

// On which side of the line ab, seen along X, p lies: 1 or -1. Swapping a and b negates the result exactly, so two
// triangles agree about their common edge. A point on the line is to the left of an edge that points upwards.
int side(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& p) {
    const bool swapped = b.y < a.y || (b.y == a.y && b.z < a.z);
    const glm::dvec3 &from = swapped ? b : a, &to = swapped ? a : b;
    const double cross = (to.y - from.y) * (p.z - from.z) - (to.z - from.z) * (p.y - from.y);
    return (cross >= 0.0) != swapped ? 1 : -1;
}

// Returns the parameter of the hit; infinity for a miss (Moeller and Trumbore, 1997).
double distance_to(const glm::dvec3& origin, const glm::dvec3& direction, const glm::dvec3& a, const glm::dvec3& b,
                   const glm::dvec3& c) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const glm::dvec3 u = b - a, v = c - a, across = glm::cross(direction, v);
    const double determinant = glm::dot(u, across);
    if (determinant == 0.0) return infinity;
    const glm::dvec3 from = origin - a, turned = glm::cross(from, u);
    const double s = glm::dot(from, across) / determinant, t = glm::dot(direction, turned) / determinant;
    if (!(s >= 0.0) || !(t >= 0.0) || !(s + t <= 1.0)) return infinity;
    const double at = glm::dot(v, turned) / determinant;
    return at >= 0.0 && at <= 1.0 ? at : infinity;
}

// By vertex of a cluster: a bit for each of four half-spaces that hold it. A triangle whose corners share a bit lies in
// that half-space.
using Sides = std::array<uint8_t, 256>;

bool is_beyond(const Sides& sides, const std::array<uint8_t, 3>& triangle) {
    return (sides[triangle[0]] & sides[triangle[1]] & sides[triangle[2]]) != 0;
}

// The sides of coordinates at two planes.
uint8_t sides_of(double y, double z, double low_y, double high_y, double low_z, double high_z) {
    return static_cast<uint8_t>((y < low_y ? 1 : 0) | (y > high_y ? 2 : 0) | (z < low_z ? 4 : 0)
                                | (z > high_z ? 8 : 0));
}

// A line as two planes that meet in it. A triangle that has all corners on one side of one of them misses the line.
class LinePlanes {
  public:
    // `size` bounds the coordinates of the triangles.
    LinePlanes(const glm::dvec3& from, const glm::dvec3& way, double size) {
        constexpr double rounding = 1e-12; // far above the error of a scalar product
        const glm::dvec3 axis = std::abs(way.x) <= std::abs(way.y) && std::abs(way.x) <= std::abs(way.z)
                                    ? glm::dvec3(1.0, 0.0, 0.0)
                                : std::abs(way.y) <= std::abs(way.z) ? glm::dvec3(0.0, 1.0, 0.0)
                                                                     : glm::dvec3(0.0, 0.0, 1.0);
        y_ = glm::normalize(glm::cross(way, axis));
        z_ = glm::normalize(glm::cross(way, y_));
        at_y_ = glm::dot(y_, from);
        at_z_ = glm::dot(z_, from);
        tolerance_ = rounding * (size + glm::length(from));
    }
    // A NaN, of a segment without length, is on no side.
    [[nodiscard]] uint8_t sides_of(const glm::dvec3& p) const {
        return fracture::sides_of(glm::dot(y_, p) - at_y_, glm::dot(z_, p) - at_z_, -tolerance_, tolerance_,
                                  -tolerance_, tolerance_);
    }

  private:
    glm::dvec3 y_, z_; // unit normals
    double at_y_, at_z_, tolerance_;
};

} // namespace

void RayWinding::add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    if ((a.y < from_.y && b.y < from_.y && c.y < from_.y) || (a.y > from_.y && b.y > from_.y && c.y > from_.y)
        || (a.z < from_.z && b.z < from_.z && c.z < from_.z) || (a.z > from_.z && b.z > from_.z && c.z > from_.z))
        return;
    const int s = side(a, b, from_);
    if (side(b, c, from_) != s || side(c, a, from_) != s) return;
    if (glm::dot(from_ - a, glm::cross(b - a, c - a)) * s < 0.0) winding_ += s;
}

bool is_inside(const ClusterMesh& mesh, const glm::dvec3& point) {
    RayWinding ray(point);
    mesh.visit(ray.reach(mesh.box()), [&](const ClusterPtr& cluster) {
        Sides sides;
        for (size_t v = 0; v < cluster->positions.size(); ++v) {
            const glm::dvec3& p = cluster->positions[v];
            sides[v] = sides_of(p.y, p.z, point.y, point.y, point.z, point.z);
        }
        for (const std::array<uint8_t, 3>& triangle : cluster->triangles) {
            if (is_beyond(sides, triangle)) continue;
            const auto& [a, b, c] = triangle;
            ray.add(cluster->positions[a], cluster->positions[b], cluster->positions[c]);
        }
    });
    return ray.winding() > 0;
}

std::optional<double> first_hit(const ClusterMesh& mesh, const glm::dvec3& from, const glm::dvec3& to) {
    double nearest = std::numeric_limits<double>::infinity();
    const glm::dvec3 way = to - from, inverse = 1.0 / way; // infinite along an axis with a zero component
    const auto on_way = [&](const Box& box) {
        double begin = 0.0, end = std::min(nearest, 1.0);
        for (int k = 0; k < 3; ++k) {
            double near = (box.min[k] - from[k]) * inverse[k], far = (box.max[k] - from[k]) * inverse[k];
            if (near > far) std::swap(near, far);
            if (near > begin) begin = near; // a NaN from 0 x infinity is ignored
            if (far < end) end = far;
        }
        constexpr double rounding = 1e-9;
        return begin <= end + rounding;
    };
    const Box box = mesh.box();
    const LinePlanes line(from, way, glm::length(glm::max(glm::abs(box.min), glm::abs(box.max))));
    mesh.visit_where(on_way, [&](const ClusterPtr& cluster) {
        Sides sides;
        for (size_t v = 0; v < cluster->positions.size(); ++v) sides[v] = line.sides_of(cluster->positions[v]);
        for (const std::array<uint8_t, 3>& triangle : cluster->triangles) {
            if (is_beyond(sides, triangle)) continue;
            const auto& [a, b, c] = triangle;
            nearest = std::min(
                nearest, distance_to(from, way, cluster->positions[a], cluster->positions[b], cluster->positions[c]));
        }
    });
    return nearest <= 1.0 ? std::optional(nearest) : std::nullopt;
}

double farthest_along(const ClusterMesh& mesh, const glm::dvec3& from, const glm::dvec3& direction) {
    double farthest = -std::numeric_limits<double>::infinity();
    const auto may_be_farther = [&](const Box& box) {
        glm::dvec3 corner;
        for (int k = 0; k < 3; ++k) corner[k] = direction[k] > 0.0 ? box.max[k] : box.min[k];
        return glm::dot(corner - from, direction) >= farthest;
    };
    mesh.visit_where(may_be_farther, [&](const ClusterPtr& cluster) {
        for (const glm::dvec3& p : cluster->positions) farthest = std::max(farthest, glm::dot(p - from, direction));
    });
    return mesh.triangle_count() == 0 ? 0.0 : farthest;
}

double farthest_from(const ClusterMesh& mesh, const glm::dvec3& point) {
    double farthest = 0.0;
    const auto may_be_farther = [&](const Box& box) {
        return glm::length(glm::max(glm::abs(box.min - point), glm::abs(box.max - point))) >= farthest;
    };
    mesh.visit_where(may_be_farther, [&](const ClusterPtr& cluster) {
        for (const glm::dvec3& p : cluster->positions) farthest = std::max(farthest, glm::distance(p, point));
    });
    return farthest;
}

glm::dvec3 nearest_on(const ClusterMesh& mesh, const glm::dvec3& point) {
    glm::dvec3 best = point;
    double least = std::numeric_limits<double>::infinity();
    if (mesh.triangle_count() == 0) return best;
    // A box that doubles until it is sure to hold the nearest point.
    double reach = 0.5e-3 * glm::length(mesh.box().size());
    do {
        reach = std::max(2.0 * reach, std::numeric_limits<double>::min());
        mesh.visit({point - reach, point + reach}, [&](const ClusterPtr& cluster) {
            for (const auto& [a, b, c] : cluster->triangles) {
                const glm::dvec3 at =
                    nearest_on_triangle(point, cluster->positions[a], cluster->positions[b], cluster->positions[c]);
                if (const double d = glm::distance(at, point); d < least) {
                    least = d;
                    best = at;
                }
            }
        });
    } while (!(least <= reach));
    return best;
}

} // namespace brittle::fracture
