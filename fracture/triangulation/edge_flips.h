// Lawson's edge flips: improves the triangles of an ear clipper towards Delaunay. Internal to ring.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fracture/mesh/mesh.h"
#include "fracture/triangulation/ring_nodes.h"

namespace brittle::fracture::triangulation {

// The triangles of one ring. Half-edge 3 t + k runs from corner k of triangle t to the next corner.
struct RingTriangles {
    std::vector<Triangle> corners; // node indices
    std::vector<uint32_t> twin;    // per half-edge: its twin, or no_index

    void clear() {
        corners.clear();
        twin.clear();
    }
};

class EdgeFlips {
  public:
    // Flips an edge if both new triangles are strictly positive and either an old triangle is not (a forced ear) or the
    // circle test is certain. Each flip reduces the count of non-positive triangles or lowers the lifted surface, so
    // the sequence ends.
    //
    // `edges`: the edges outside this ring, which no flip may repeat; or null. `overlapping`: triangles may overlap,
    // and a flip may therefore propose an edge that another triangle of the ring has.
    void run(std::span<const Node> nodes, RingTriangles& triangles, EdgeSet* edges, bool overlapping);

  private:
    struct Quad {
        uint32_t a, b, c, d; // the edge a -> b, the apex c on its left and d on its right
    };

    [[nodiscard]] static Quad quad_at(const RingTriangles& triangles, uint32_t h);
    [[nodiscard]] static bool should_flip(std::span<const Node> nodes, const Quad& q, const EdgeSet* edges);
    // Replaces (a, b, c), (b, a, d) by (a, d, c), (d, b, c). Returns false if the two triangles share another edge.
    bool flip(RingTriangles& triangles, uint32_t h, const Quad& q);

    EdgeSet own_edges_;           // edges of overlapping triangles
    std::vector<uint32_t> stack_; // half-edges to test
};

} // namespace brittle::fracture::triangulation
