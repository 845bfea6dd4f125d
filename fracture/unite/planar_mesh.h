// A triangulation of a triangle that takes points and constrained edges one by one.
//
// Orientations are exact (points.h), so every face has area and the orientation of the whole triangle. Edges are flipped
// towards Delaunay where that is certain in doubles; this serves the shape of faces only.
//
//     PlanarMesh planar(points);
//     planar.start(corners, axis);                      // indices 0, 1, 2
//     const uint32_t p = planar.divide_boundary(0, 1, point);
//     const uint32_t q = planar.insert(other_point);
//     planar.constrain(p, q);
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fracture/unite/points.h"

namespace brittle::fracture::arrangement {

class PlanarMesh {
  public:
    struct Face {
        std::array<uint32_t, 3> corner;     // counter-clockwise as the corners of the whole
        std::array<uint32_t, 3> beside;     // the face beyond the edge from corner k to the next; no_index outside
        std::array<uint8_t, 3> constrained; // per edge
    };

    explicit PlanarMesh(const Points& points) : points_(points) {}

    // Starts with one triangle, whose edges are constrained. `axis`: a projection in which it has area.
    void start(const std::array<uint32_t, 3>& corners, int axis);
    // Adds a point of the boundary between two of its points that are neighbours. Returns the index.
    uint32_t divide_boundary(uint32_t from, uint32_t to, uint32_t point);
    // Adds a point inside. Returns the index. Precondition: the point is not there yet.
    uint32_t insert(uint32_t point);
    // Makes an edge between two indices. Precondition: no point and no constrained edge lies between them.
    void constrain(uint32_t from, uint32_t to);

    // Corners of faces are indices. point() names the point of an index.
    [[nodiscard]] const std::vector<Face>& faces() const { return faces_; }
    [[nodiscard]] uint32_t point(uint32_t index) const { return point_[index]; }

  private:
    struct Side { // an edge of a face
        uint32_t face;
        size_t edge;
    };
    struct DirectedEdge { // of a face that was removed
        uint32_t from, to, beside;
        uint8_t constrained;
    };

    [[nodiscard]] int turn(uint32_t a, uint32_t b, uint32_t c) const {
        return sign_ * points_.turn(point_[a], point_[b], point_[c], axis_);
    }
    uint32_t add(uint32_t point);
    void put(uint32_t face, const Face& content);
    void relink(uint32_t face, uint32_t from, uint32_t to, uint32_t beside);
    [[nodiscard]] Side find(uint32_t from, uint32_t to) const;
    [[nodiscard]] Side locate(uint32_t index) const;
    void split_face(uint32_t face, uint32_t index);
    void split_edge(Side side, uint32_t index);
    void flip_towards_delaunay();
    [[nodiscard]] bool should_flip(uint32_t face, size_t edge) const;
    void flip(uint32_t face, size_t edge);
    void mark(Side side);
    void replace(std::span<const uint32_t> removed, std::span<const std::array<uint32_t, 3>> added);
    void fill(std::vector<uint32_t> polygon, std::vector<std::array<uint32_t, 3>>& out) const;
    [[nodiscard]] bool is_ear(const std::vector<uint32_t>& polygon, size_t k) const;

    const Points& points_;
    int axis_ = 0;
    int sign_ = 1;                  // of the turn of the whole triangle in projection
    std::vector<uint32_t> point_;   // per index
    std::vector<uint32_t> face_of_; // per index: a face with this corner
    std::vector<Face> faces_;
    uint32_t last_ = 0;          // where the next search begins
    std::vector<Side> doubtful_; // edges that may need a flip
};

} // namespace brittle::fracture::arrangement
