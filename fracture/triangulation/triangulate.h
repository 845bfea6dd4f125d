// Ear clipping of a planar region with any number of outer loops, holes, and islands in holes.
//
// "Real Time Voronoi Fracturing of Polygon Meshes", section 2.4, extended: loops are nested by containment,
// holes are bridged to their outer loop (Eberly, "Triangulation by Ear Clipping"), ears are found as by
// ElGindy, Everett and Toussaint. A clipper that must go on always does: for a loop of n vertices it emits n
// - 2 triangles whatever the geometry, so that what is closed by construction stays closed.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// A closed polyline of point indices, without repetition of the first. Outer loops run counter-clockwise,
// holes clockwise (the solid lies to the left).
using Loop = std::vector<uint32_t>;

struct Triangulation {
    std::vector<Triangle> triangles; // counter-clockwise, indices as in the loops
    uint32_t forced_ears = 0;        // ears cut although they were not strictly valid; 0 for simple input
    uint64_t vertex_tests = 0;       // vertices looked at in search of ears, the cost that grows fastest
};

// Triangulates the region to the left of the loops. Every loop edge appears exactly once in its own
// direction, every other edge exactly once in each direction, so the result closes the hole that the loops
// bound. No point is added, collinear points are kept. Signs are exact (plane_predicates.h); the same on
// every machine.
//
// A loop of n distinct points gives n - 2 triangles, and each hole of m points m + 2 more. A loop that visits
// an index twice is split there into loops that touch; parts of fewer than three points, whose edges cancel,
// give none. Loops of fewer than three points are the caller's bug. Two points in one place with different
// indices are two points. A clockwise loop that no outer loop contains is reversed geometry (inside-out
// input): it is triangulated clockwise. Loops that cross, lie on each other or are not finite are
// triangulated all the same, with forced ears. Edges are flipped towards Delaunay afterwards, never making an
// edge that the pair of its ends already has.
//
// Near-linear time on simple loops (10,000 points: 3 ms), quadratic at worst on tangled ones.
[[nodiscard]] Triangulation triangulate(std::span<const glm::dvec2> points, std::span<const Loop> loops);

// The same with memory that is kept: for many regions, hardly anything is allocated after the first. One for each thread.
class Triangulator {
  public:
    Triangulator();
    ~Triangulator();
    Triangulator(Triangulator&&) noexcept;
    Triangulator& operator=(Triangulator&&) noexcept;

    // Valid until the next call.
    const Triangulation& run(std::span<const glm::dvec2> points, std::span<const Loop> loops);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

// Projects points on a plane onto two dimensions by dropping the dominant axis of the normal;
// counter-clockwise seen against the normal stays counter-clockwise.
[[nodiscard]] glm::dvec2 project(const glm::dvec3& point, const glm::dvec3& normal);

} // namespace brittle::fracture
