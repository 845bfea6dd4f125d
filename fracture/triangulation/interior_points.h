// Adds points inside a triangulated planar region, for surfaces that are flat in the plane and bent afterwards.
//
//     std::vector<glm::dvec2> points = ...;             // of the loops
//     std::vector<Triangle> triangles = triangulate(points, loops).triangles;
//     InteriorPoints inserter;
//     inserter.run(loops, spacing, normals, points, triangles);  // both grow
//
// The new points lie on a lattice of equilateral triangles, at a distance from the border. Each is inserted into the
// triangle around it, and edges are flipped towards Delaunay (Lawson 1977). The border stays as it is: every loop edge
// keeps its one triangle.
//
// The border may lie on a surface that is flat after the bend. A triangle with all corners there would lie in that
// surface, so edges are flipped until few triangles do.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"
#include "fracture/triangulation/triangulate.h"

namespace brittle::fracture {

// Reuses its memory. Not synchronised: one object per thread.
class InteriorPoints {
  public:
    // The unit normals of the surfaces that a point of the border lies on; zero for none.
    using Normals = std::array<glm::dvec3, 2>;

    // `spacing` is the distance of adjacent lattice points, in the unit of the points; `normals` has one entry a point.
    // Preconditions: the triangles are strictly counter-clockwise, those of a triangulation of the loops without forced
    // ears; the spacing is positive. The result is equal on every machine. Time is near linear in the points.
    void run(std::span<const Loop> loops, double spacing, std::span<const Normals> normals,
             std::vector<glm::dvec2>& points, std::vector<Triangle>& triangles);

  private:
    void place_points(std::span<const Loop> loops, double spacing, std::span<const glm::dvec2> border);
    void find_twins(std::span<const Triangle> triangles);
    void insert(uint32_t point, std::span<const glm::dvec2> points, std::vector<Triangle>& triangles);
    [[nodiscard]] uint32_t locate(uint32_t point, std::span<const glm::dvec2> points,
                                  std::span<const Triangle> triangles) const;
    [[nodiscard]] bool is_flat(uint32_t a, uint32_t b, uint32_t c) const;
    void leave_border(std::span<const glm::dvec2> points, std::vector<Triangle>& triangles);
    bool is_flippable(uint32_t half, std::span<const glm::dvec2> points, std::span<const Triangle> triangles) const;
    void flip(uint32_t half, std::vector<Triangle>& triangles);
    void make_delaunay(std::span<const glm::dvec2> points, std::vector<Triangle>& triangles);

    std::vector<glm::dvec2> inside_;
    std::vector<std::array<uint32_t, 3>> sorted_; // lower end, upper end, half-edge
    std::vector<uint32_t> twin_;     // per half-edge; 3 t + k runs from corner k of triangle t to the next corner
    std::vector<uint32_t> doubtful_; // half-edges to test
    std::vector<std::array<uint32_t, 2>> segments_;  // of the loops
    std::vector<uint32_t> bin_begin_, bins_;         // the border points in square bins
    std::vector<uint32_t> row_begin_, row_segments_; // the segments at each row of the lattice
    std::vector<double> crossings_;
    std::vector<std::array<double, 2>> too_near_; // the intervals of a row that are too near to a segment
    std::span<const Normals> normals_;
    uint32_t near_ = 0; // a triangle near the last point
};

} // namespace brittle::fracture
