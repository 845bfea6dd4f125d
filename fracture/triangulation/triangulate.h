// Triangulation of a planar region with any number of outer loops, holes, and islands in holes, by ear clipping.
//
// "Real Time Voronoi Fracturing of Polygon Meshes", section 2.4, with these extensions: loops are nested by
// containment, holes are bridged to their outer loop (Eberly, "Triangulation by Ear Clipping"), and ears are found as
// by ElGindy, Everett and Toussaint. The clipper never gives up: a loop of n vertices gives n - 2 triangles whatever
// its geometry, so a surface that is closed by construction stays closed.
//
//     const std::vector<glm::dvec2> points = {{0, 0}, {2, 0}, {2, 1}, {0, 1}};
//     const std::vector<Loop> loops = {{0, 1, 2, 3}};
//     const Triangulation result = triangulate(points, loops); // two triangles
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// A closed polyline of point indices; the first is not repeated at the end. Outer loops run counter-clockwise, holes
// clockwise: the region lies to the left.
using Loop = std::vector<uint32_t>;

struct Triangulation {
    std::vector<Triangle> triangles; // counter-clockwise; indices refer to the points
    uint32_t forced_ears = 0;        // ears that were cut although they are not strictly valid; 0 for simple input
    uint64_t vertex_tests = 0;       // vertices tested in the search for ears: the dominant cost
};

// Triangulates the region to the left of the loops. Every loop edge appears exactly once, in its own direction, and
// every other edge exactly once in each direction, so the result closes the hole that the loops bound. No points are
// added; collinear points are kept. Signs are exact (plane_predicates.h) and the result is equal on every machine.
//
// A loop of n distinct points gives n - 2 triangles; each hole of m points adds m + 2. A loop that visits an index
// twice is split there into loops that touch; parts of fewer than three points give no triangle, as their edges cancel.
// Precondition: loops have at least three points. Points with different indices are different points, even at one
// position. A clockwise loop outside all outer loops is inside-out geometry and is triangulated clockwise. Loops that
// cross, overlap or are not finite are triangulated with forced ears. Finally edges are flipped towards Delaunay; a
// flip never creates a second edge between two points.
//
// Time is near linear for simple loops and at worst quadratic for tangled ones.
[[nodiscard]] Triangulation triangulate(std::span<const glm::dvec2> points, std::span<const Loop> loops);

// triangulate() with reused memory: hardly anything is allocated after the first of many regions. Not synchronised: one
// object per thread.
class Triangulator {
  public:
    Triangulator();
    ~Triangulator();
    Triangulator(Triangulator&&) noexcept;
    Triangulator& operator=(Triangulator&&) noexcept;

    // The result is valid until the next call.
    const Triangulation& run(std::span<const glm::dvec2> points, std::span<const Loop> loops);

    // Triangulates as run() does, faster where every loop is simple and counter-clockwise: these loops take the fast
    // path (simple_loop.h), and run() follows where it refuses one. Diagonals may differ from those of run(). No index
    // may occur twice in the loops. Valid until the next call.
    const Triangulation& run_simple(std::span<const glm::dvec2> points, std::span<const Loop> loops);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

// Projects a point of a plane onto two dimensions by dropping the dominant axis of the normal. A loop that is
// counter-clockwise around the normal stays counter-clockwise.
[[nodiscard]] glm::dvec2 project(const glm::dvec3& point, const glm::dvec3& normal);

} // namespace brittle::fracture
