// The fast path of the triangulator: ear clipping of one simple counter-clockwise loop. Internal to triangulate.cpp.
//
// Nine of ten caps of a fracture are one loop of this kind. The loop is clipped ear by ear (Meisters, "Polygons have
// ears"; only concave vertices can lie in an ear, ElGindy, Everett and Toussaint), then its diagonals are flipped
// towards Delaunay. All arithmetic is in double. A loop that double cannot settle (a collinear or repeated point, no
// strict ear) or that has many concave vertices is refused; Ring (ring.h) triangulates every loop.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture::triangulation {

// Keeps its memory for the next loop.
class SimpleLoop {
  public:
    // Appends n - 2 counter-clockwise triangles to `out`, for the n points of the loop. ids[k] is the index of
    // points[k] in these triangles. Returns false, with nothing appended, where the loop is not certainly simple and
    // counter-clockwise.
    bool triangulate(std::span<const glm::dvec2> points, std::span<const uint32_t> ids, std::vector<Triangle>& out);

  private:
    bool find_concave(std::span<const glm::dvec2> points);
    [[nodiscard]] bool is_ear(std::span<const glm::dvec2> points, uint32_t v) const;
    void remove_concave(uint32_t v);
    bool cut_ears(std::span<const glm::dvec2> points);
    void cut(uint32_t v);
    void flip_edges(std::span<const glm::dvec2> points);
    bool flip_edge(std::span<const glm::dvec2> points, uint32_t half_edge);

    // Per vertex of the loop. The neighbours and the outer half-edge belong to the polygon that is left to clip.
    std::vector<uint32_t> next_, prev_;
    std::vector<uint32_t> outer_; // the half-edge across the edge from this vertex to the next; no_index on the loop
    std::vector<int8_t> turn_;    // 1 convex, -1 concave

    // The concave vertices that are left, in any order, and their points: arrays for a vectorised test.
    std::vector<uint64_t> concave_;
    std::vector<double> concave_x_, concave_y_;

    // Triangle t has the half-edges 3t + k, from its corner k to the next corner.
    std::vector<uint32_t> corner_;  // per half-edge: the vertex where it starts
    std::vector<uint32_t> twin_;    // per half-edge; no_index on the loop
    std::vector<uint32_t> pending_; // half-edges to test for a flip
};

} // namespace brittle::fracture::triangulation
