// Interface for classifying mesh vertices and triangles by Voronoi cell on another device, for example a GPU.
//
// A classifier may compute in any precision. It must mark every result that rounding may have changed; the exact
// algorithm decides the marked ones on the CPU. The pieces are therefore equal, bit for bit, with any classifier and
// without one.
//
//     settings.classifier = &classifier; // start() runs before the Voronoi cells are built, finish() after
//
// One fracture at a time may use a classifier. The calls come from the thread that called fracture().
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

class Classifier {
  public:
    static constexpr uint32_t uncertain = 0x80000000u; // flag of a vertex: the nearest site is in doubt

    // Result for a triangle: the index of a site, or the flag `crossing` combined with any of the flags below. A flag
    // may be set only where its statement holds beyond doubt. Let a, b and c be the cells of the three corners; all
    // three must be certain, and distinct for every flag other than edge_alone. With these flags the cut skips the walk
    // along an edge or the clipping of a triangle that spans three cells.
    //  - edge_alone(e): the edge from corner e to the next corner passes through the cells of its two ends only, so no
    //    other bisector matters. Set in the triangle that traverses the edge from its lower vertex index to the
    //    higher.
    //  - point_alone: the point of the triangle's plane that is equidistant from the sites of a, b and c is farther
    //    from all other sites.
    //  - sign_known(e), sign_first(e): whether the side of the third corner is known with respect to the bisector
    //    between the cells at the ends of edge e, and whether it is the side of the edge's first corner. The signs of
    //    the edge's own ends are known, so these bits complete the sign pattern of the paper, one of eight.
    static constexpr uint32_t crossing = 0x80000000u;
    static constexpr uint32_t edge_alone(uint32_t e) { return 1u << e; }
    static constexpr uint32_t point_alone = 1u << 3;
    static constexpr uint32_t sign_known(uint32_t e) { return 1u << (4 + 2 * e); }
    static constexpr uint32_t sign_first(uint32_t e) { return 1u << (5 + 2 * e); }

    // Input of a classification. Coordinates are scaled so that the mesh is about one unit long. Vertices lie in the
    // box, sites may lie outside.
    struct Problem {
        std::span<const glm::dvec3> positions;
        std::span<const Triangle> triangles; // of indices below positions.size()
        std::span<const glm::dvec3> sites;   // fewer than 2^31
        Box box;
    };

    virtual ~Classifier() = default;

    // Starts the classification; may return before it is complete. The arrays of the problem stay valid until finish()
    // or the next start(). Returns false if the classifier is unavailable; finish() is then not called.
    virtual bool start(const Problem& problem) = 0;

    // Waits for the results and writes them.
    //
    // Vertices: the index of the nearest site, with the bit `uncertain` set wherever the answer is not proved. Without
    // the bit, |x - s_l| > |x - s_c| must hold in exact arithmetic for every other site l; among coincident sites the
    // answer must be the lowest index or carry the bit.
    //
    // Triangles: the site, if all three corners have it beyond doubt; otherwise `crossing` and its flags.
    //
    // Returns false if the results are unusable; the spans may then hold anything.
    virtual bool finish(std::span<uint32_t> site_of_vertex, std::span<uint32_t> site_of_triangle) = 0;
};

} // namespace brittle::fracture
