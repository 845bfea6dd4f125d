// One ring of an ear clipper: an outer loop, its holes bridged in, and the triangles it falls into. Internal to
// triangulate.cpp. Keeps its memory for the next ring.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <glm/vec2.hpp>

#include "fracture/triangulation/edge_flips.h"
#include "fracture/triangulation/loop_nesting.h"
#include "fracture/triangulation/ring_nodes.h"

namespace brittle::fracture::triangulation {

// Call start(), then the phases in their order, then emit().
class Ring {
  public:
    // edges: of all loops and of what has been cut so far; null where no diagonal can repeat an edge.
    void start(std::span<const glm::dvec2> points, EdgeSet* edges);

    // Phase 1: the outer loop. Clockwise ones are turned round, and their triangles back when they are
    // emitted.
    void set_outer(const LoopInfo& loop);

    // Phase 2: holes, by their lexicographically largest vertex, largest first: each can then see a vertex of
    // what is already merged, and no hole still to come is in the way (Eberly).
    void bridge_holes(std::span<const LoopInfo> loops, uint32_t outer);

    // Phase 3: ears until a triangle is left.
    void clip();

    // Phase 4: edges are flipped towards Delaunay.
    void flip_edges() { flips_.run(nodes_, triangles_, edges_, forced_ > 0); }

    void emit(Triangulation& out) const;

  private:
    uint32_t add_loop(const LoopInfo& loop);
    double turn_at(const Node& n) const;

    // --- bridges
    bool opens_towards(const Node& n, const glm::dvec2& p) const;
    bool is_bridge(const Node& m, const Node& q) const;
    uint32_t find_bridge(uint32_t tip);
    void bridge(uint32_t m, uint32_t q);

    // --- triangles and their neighbours
    void link(uint32_t h, uint32_t across);
    void add_triangle(uint32_t a, uint32_t b, uint32_t c);
    void cut(uint32_t t);
    void cut_last();

    // --- ears
    bool is_convex() const;
    void clip_convex();
    void start_clipping();
    void push(uint32_t i);
    bool may_join(const Node& a, const Node& b) const;
    bool is_ear(uint32_t t);
    void release_waiting(uint32_t blocker);
    void cut_and_update(uint32_t t);
    void forget(uint32_t i);
    void update(uint32_t i);
    void close_off_around(uint32_t t);
    uint32_t min_bad_ear() const;

    std::span<const glm::dvec2> points_;
    EdgeSet* edges_ = nullptr;
    std::vector<Node> nodes_;
    std::vector<uint32_t> tips_;                          // of the holes
    std::vector<std::pair<double, uint32_t>> candidates_; // for a bridge: distance and node
    uint32_t start_ = none;                               // a node of the ring
    uint32_t count_ = 0;                                  // nodes in the ring, with those of holes not bridged yet
    bool reversed_ = false;

    std::vector<uint32_t> queue_; // nodes that may be ears; those before head_ are done
    size_t head_ = 0;
    std::vector<Wait> waits_;
    ReflexGrid grid_;
    uint32_t forced_ = 0;
    uint64_t vertex_tests_ = 0;

    RingTriangles triangles_;
    std::vector<uint32_t> bridge_half_edge_; // per bridge the side that came first
    EdgeFlips flips_;
};

} // namespace brittle::fracture::triangulation
