// Lawson's edge flips: what an ear clipper cut, made as near to Delaunay as may be. Internal to ring.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fracture/mesh/mesh.h"
#include "fracture/triangulation/ring_nodes.h"

namespace brittle::fracture::triangulation {

// The triangles of one ring. Half-edge 3 t + k runs from corner k of triangle t to the next.
struct RingTriangles {
    std::vector<Triangle> corners; // node indices
    std::vector<uint32_t> twin;    // per half-edge the one across, or none

    void clear() {
        corners.clear();
        twin.clear();
    }
};

class EdgeFlips {
  public:
    // An edge is flipped where both new triangles are strictly positive and either an old one was not (a forced
    // ear), or the circle test certainly asks for it. Each flip lowers the number of non-positive triangles or
    // the lifted surface, so the sequence ends.
    //
    // edges: all that exist elsewhere, which no flip may make again; or null. overlapping: triangles may lie on
    // each other, and so propose an edge that one of themselves has.
    void run(std::span<const Node> nodes, RingTriangles& triangles, EdgeSet* edges, bool overlapping);

  private:
    struct Quad {
        uint32_t a, b, c, d; // corners: the edge a -> b, the apex c on its left, d on its right
    };

    [[nodiscard]] static Quad quad_at(const RingTriangles& triangles, uint32_t h);
    [[nodiscard]] static bool should_flip(std::span<const Node> nodes, const Quad& q, const EdgeSet* edges);
    // (a, b, c), (b, a, d) become (a, d, c), (d, b, c); false where the two share another edge.
    bool flip(RingTriangles& triangles, uint32_t h, const Quad& q);

    EdgeSet own_edges_;           // of overlapping triangles
    std::vector<uint32_t> stack_; // half-edges to look at
};

} // namespace brittle::fracture::triangulation
