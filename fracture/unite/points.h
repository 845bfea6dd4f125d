// The points of an arrangement of triangles: vertices of the mesh, and points where its edges and triangles cross.
//
// Each point has exact homogeneous coordinates and a position, which is these coordinates rounded to doubles. Points
// are equal where their exact coordinates are equal, whatever construction they come from. Predicates look at
// positions first; where the rounding could change the sign, they decide on the exact coordinates.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/arithmetic/dyadic.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture::arrangement {

using Corners = std::array<glm::dvec3, 3>;

// The point (x, y, z) / w, with w > 0.
struct ExactPoint {
    exact::Dyadic x, y, z, w;

    [[nodiscard]] const exact::Dyadic& operator[](int axis) const { return axis == 0 ? x : (axis == 1 ? y : z); }
};

[[nodiscard]] ExactPoint exact_point(const glm::dvec3& p);

// The plane normal . p = offset.
struct ExactPlane {
    std::array<exact::Dyadic, 3> normal;
    exact::Dyadic offset;
};

// Returns the plane through a triangle; the normal points to the side from which the corners are counter-clockwise.
[[nodiscard]] ExactPlane plane_of(const Corners& triangle);
// Returns the plane through the line pq that is parallel to an axis.
[[nodiscard]] ExactPlane plane_along(const glm::dvec3& p, const glm::dvec3& q, int axis);

// Returns the point of the line pq on the plane. Precondition: the line is not parallel to the plane.
[[nodiscard]] ExactPoint on_line(const glm::dvec3& p, const glm::dvec3& q, const ExactPlane& plane);
// Returns the common point of three planes. Precondition: there is exactly one.
[[nodiscard]] ExactPoint common_point(const ExactPlane& a, const ExactPlane& b, const ExactPlane& c);

class Points {
  public:
    // The vertices of the mesh are the points with their indices; of vertices at one position only the first is used,
    // see first_at().
    explicit Points(std::span<const glm::dvec3> vertices);

    [[nodiscard]] size_t size() const { return positions_.size(); }
    [[nodiscard]] const glm::dvec3& operator[](uint32_t point) const { return positions_[point]; }
    [[nodiscard]] bool is_vertex(uint32_t point) const { return point < vertices_; }
    [[nodiscard]] ExactPoint exact(uint32_t point) const;

    // Returns the point with these coordinates, which it adds where there is none.
    uint32_t add(const ExactPoint& coordinates);

    // Returns the first of all points with the same position. Points of one position may differ exactly.
    [[nodiscard]] uint32_t first_at(uint32_t point) const { return first_[point]; }

    // Returns the sign of the difference of coordinates along an axis, a - b.
    [[nodiscard]] int compare(uint32_t a, uint32_t b, int axis) const;
    // Returns an axis along which two points differ, the one with the largest difference of positions.
    [[nodiscard]] int axis_between(uint32_t a, uint32_t b) const;
    // Returns 1 if a, b, c turn counter-clockwise in projection along an axis, -1 for clockwise, 0 for collinear. The
    // projection keeps the axes (axis + 1) % 3 and (axis + 2) % 3, in this order.
    [[nodiscard]] int turn(uint32_t a, uint32_t b, uint32_t c, int axis) const;
    // Returns 1 for a point in front of a triangle's plane, where the corners are counter-clockwise, -1 behind, 0 on.
    [[nodiscard]] int side(const Corners& triangle, uint32_t point) const;

  private:
    void grow();
    [[nodiscard]] size_t slot_of(const glm::dvec3& position) const;

    size_t vertices_;
    std::vector<glm::dvec3> positions_;
    std::vector<ExactPoint> exact_;   // of the points that are no vertices
    std::vector<uint32_t> first_;     // per point
    std::vector<uint32_t> next_same_; // per point: the next one with the same position, or no_index
    std::vector<uint32_t> table_;     // hash table of the first points
    size_t used_ = 0;
};

// Returns the sign of side() for an explicit point.
[[nodiscard]] int side_of(const Corners& triangle, const glm::dvec3& p);

// Returns an axis along which the triangle projects to a triangle with area, the best one in doubles; -1 for a triangle
// without area.
[[nodiscard]] int open_axis(const Corners& triangle);

} // namespace brittle::fracture::arrangement
