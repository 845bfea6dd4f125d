// Where a fracture's classification may run instead of the CPU: on a GPU, or any other device.
//
// A classifier may guess, in whatever precision it likes, as long as it marks what rounding could have
// changed. What is marked is decided exactly on the CPU, so any classifier, or none, gives the same pieces
// bit for bit.
//
//     settings.classifier = &classifier; // start() runs before the Voronoi cells are built, finish() after
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

class Classifier {
  public:
    static constexpr uint32_t uncertain = 0x80000000u; // a bit of a vertex's answer

    // A triangle's answer is a site, or `crossing` and any of these bits, each of which may be set only where it is true
    // beyond doubt. a, b, c are the corners' cells, which must be certain and, but for edge_alone, three. They are what the
    // cut asks first: with them an edge needs no walk, and a triangle of three cells no clipping.
    //  - edge_alone(e): the edge from corner e to the next runs through its ends' two cells only: no other bisector
    //    has a sign that matters. Asked of the triangle that runs the edge from its lower vertex to its higher.
    //  - point_alone: the point of the triangle's plane that is equally far from the sites of a, b and c is farther
    //    from all others.
    //  - sign_known(e), sign_first(e): on which side of the bisector between the cells of edge e's ends the third corner
    //    lies, and whether that is the side of the edge's first corner. The signs of the edge's own ends are known, so
    //    this is the paper's sign pattern, one of eight.
    static constexpr uint32_t crossing = 0x80000000u;
    static constexpr uint32_t edge_alone(uint32_t e) { return 1u << e; }
    static constexpr uint32_t point_alone = 1u << 3;
    static constexpr uint32_t sign_known(uint32_t e) { return 1u << (4 + 2 * e); }
    static constexpr uint32_t sign_first(uint32_t e) { return 1u << (5 + 2 * e); }

    // Coordinates are scaled so that the mesh is about one unit long; vertices lie in the box, sites
    // anywhere.
    struct Problem {
        std::span<const glm::dvec3> positions;
        std::span<const Triangle> triangles; // of indices below positions.size()
        std::span<const glm::dvec3> sites;   // fewer than 2^31
        Box box;
    };

    virtual ~Classifier() = default;

    // Begins, and need not wait for the result: what the problem points to stays until finish() or the next
    // start(). False: not now, and finish() is not called.
    virtual bool start(const Problem& problem) = 0;

    // For each vertex the nearest site, with the bit `uncertain` unless rounding cannot have changed the
    // answer: |x - s_l| must exceed |x - s_c| for all l in exact arithmetic; of equal sites it must be the
    // lowest index, or uncertain. For each triangle the site of its corners where they all have one, beyond
    // doubt; else `crossing` and what is known of it. False: nothing was written, or it is worth nothing.
    virtual bool finish(std::span<uint32_t> site_of_vertex, std::span<uint32_t> site_of_triangle) = 0;
};

} // namespace brittle::fracture
