// A convex hull laid out for the queries that a step makes thousands of times: support in a direction, bounds, and the
// face along a direction. They process four points or faces at a time.
//
// Bounds are those of the transformed points and not of a rotated box: in a heap of pieces half as many pairs overlap.
// Metres, in the hull's own axes. The margin is a shell around the points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "physics/solver/float4.h"
#include "physics/solver/transform.h"
#include "physics/world/hull.h"

namespace brittle::physics {

class HullShape {
  public:
    HullShape() = default;
    // Precondition: at least one point; the faces are those of the points, or none.
    HullShape(std::vector<glm::vec3> points, float margin, HullFaces faces = {});

    [[nodiscard]] const std::vector<glm::vec3>& points() const { return points_; }
    [[nodiscard]] int point_count() const { return static_cast<int>(points_.size()); }
    [[nodiscard]] float margin() const { return margin_; }

    // The points in groups of four: 4 x, 4 y, 4 z. Copies of the last point fill up the last group.
    static constexpr size_t group_size = 12;
    [[nodiscard]] std::span<const float> groups() const { return lanes_; }
    // Dot products of the four points of a group with a direction.
    static Float4 along(const float* group, const glm::vec3& direction) {
        return Float4::load(group) * Float4::all(direction.x) + Float4::load(group + 4) * Float4::all(direction.y)
               + Float4::load(group + 8) * Float4::all(direction.z);
    }

    // The bounds in a frame, margin included.
    [[nodiscard]] Bounds bounds(const Transform& frame) const;

    // The largest dot product of a point with a direction of the hull's axes, without the margin.
    [[nodiscard]] float support(const glm::vec3& direction) const;
    // The index of that point; the lowest of several.
    [[nodiscard]] int support_index(const glm::vec3& direction) const;
    // The radius of the ball around the origin that holds the hull, margin included.
    [[nodiscard]] float radius() const { return radius_; }
    // The face whose outward normal has the largest dot product with a direction; the lowest of several, and -1 for a
    // hull without faces.
    [[nodiscard]] int face_along(const glm::vec3& direction) const;
    [[nodiscard]] int face_count() const { return static_cast<int>(faces_.count()); }
    [[nodiscard]] glm::vec3 normal_of(int face) const;
    // The dot product of the face's first corner with its normal.
    [[nodiscard]] float height_of(int face) const { return heights_[static_cast<size_t>(face)]; }
    // Whether the straight way between two points lies beyond the plane of one face, moved outwards by a distance.
    [[nodiscard]] bool is_beyond(const glm::vec3& from, const glm::vec3& to, float by) const;
    // Indices of points, counter-clockwise seen from outside.
    [[nodiscard]] std::span<const uint16_t> corners_of(int face) const { return faces_.of(static_cast<size_t>(face)); }
    // The place of the face's first corner among the corners of all faces.
    [[nodiscard]] uint32_t first_corner_of(int face) const {
        return static_cast<uint32_t>(faces_.begin_of(static_cast<size_t>(face)));
    }

    // The volume within the points, m^3; 0 for a hull without faces.
    [[nodiscard]] float volume() const { return volume_; }
    // The longest side of the bounds in the hull's own axes.
    [[nodiscard]] float longest() const { return longest_; }
    // Upper bound of the distance of any point from any axis through the origin: half the diagonal of the bounds plus
    // the distance of their middle.
    [[nodiscard]] float rotation_radius() const { return rotation_radius_; }

  private:
    std::vector<glm::vec3> points_;
    std::vector<float> lanes_; // groups()
    HullFaces faces_;
    std::vector<float> normals_; // of the faces, as groups()
    std::vector<float> heights_; // of the faces; copies of the last one fill up the last four
    float margin_ = 0.0f, radius_ = 0.0f, longest_ = 0.0f, rotation_radius_ = 0.0f, volume_ = 0.0f;
};

// The largest dot product of a point of the hull with a direction of the world, without the margin.
[[nodiscard]] inline float support(const HullShape& hull, const Transform& frame, const glm::vec3& direction) {
    return hull.support(direction * frame.basis) + glm::dot(direction, frame.origin);
}

// rotation_radius() of bounds around the origin.
[[nodiscard]] float rotation_radius(const Bounds& bounds);

} // namespace brittle::physics
