// A convex polytope, cut by planes.
//
//     Polytope cell = Polytope::hull(points);
//     cell.cut({normal, distance});            // keeps normal . x <= distance
//     if (cell.volume() > 0.0) use(cell.corners());
//
// Evaluated in double, for collision hulls: corners carry rounding errors. Metres.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/box.h"
#include "physics/world/hull.h"

namespace brittle::physics {

class Polytope {
  public:
    Polytope() = default; // empty
    // The intersection of the half-spaces behind the faces of a hull, moved outwards by `beyond`. `offset` moves all.
    [[nodiscard]] static Polytope around(const CollisionHull& hull, double beyond, const glm::dvec3& offset);

    [[nodiscard]] static Polytope of(const fracture::Box& box);

    // Keeps what lies behind a plane.
    void cut(const HullPlane& plane);
    // Keeps what lies behind all planes.
    void cut(std::span<const HullPlane> planes);
    // Returns whether all of it certainly lies before some of the planes.
    [[nodiscard]] bool is_beyond_one_of(std::span<const HullPlane> planes) const;

    [[nodiscard]] bool empty() const { return ends_.size() < 4; }
    [[nodiscard]] double volume() const;
    [[nodiscard]] glm::dvec3 centre() const; // a point inside
    [[nodiscard]] fracture::Box box() const;
    // The largest coordinate along a direction; -infinity where empty.
    [[nodiscard]] double support(const glm::dvec3& direction) const;
    [[nodiscard]] size_t face_count() const { return ends_.size(); }
    // The corners of a face, counter-clockwise seen from outside. Faces that meet name the same corners.
    [[nodiscard]] std::span<const glm::dvec3> face(size_t index) const {
        const uint32_t begin = index == 0 ? 0 : ends_[index - 1];
        return std::span(corners_).subspan(begin, ends_[index] - begin);
    }

  private:
    void add_face(std::span<const glm::dvec3> face, double tolerance);

    std::vector<glm::dvec3> corners_; // of all faces, face by face
    std::vector<uint32_t> ends_;      // by face: the end of its corners; the next face begins there
};

// The planes that bound the Voronoi cell of a site: its bisectors with all others, the nearest first.
[[nodiscard]] std::vector<HullPlane> cell_planes(std::span<const glm::dvec3> sites, uint32_t cell);

} // namespace brittle::physics
