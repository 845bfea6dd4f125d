// One ring of an ear clipper: an outer loop with its holes bridged in, and the triangles that it is cut into. Internal
// to triangulate.cpp. Reuses its memory for the next ring.
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

// Call order: start(), the phases in their order, emit().
class Ring {
  public:
    // `edges`: the edges of all loops and of all ears cut so far; null if no diagonal can repeat an edge.
    void start(std::span<const glm::dvec2> points, EdgeSet* edges);

    // Phase 1: adds the outer loop. A clockwise loop is reversed; emit() reverses its triangles back.
    void set_outer(const LoopInfo& loop);

    // Phase 2: bridges the holes in descending lexicographic order of their largest vertex. Each then sees a vertex of
    // the merged ring, unobstructed by the remaining holes (Eberly).
    void bridge_holes(std::span<const LoopInfo> loops, uint32_t outer);

    // Phase 3: cuts ears until one triangle remains.
    void clip();

    // Phase 4: flips edges towards Delaunay.
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
    std::vector<uint32_t> tips_;                          // per hole: its lexicographically largest node
    std::vector<std::pair<double, uint32_t>> candidates_; // bridge candidates: squared distance and node
    uint32_t start_ = no_index;                           // any node of the ring
    uint32_t count_ = 0; // count of nodes in the ring, including holes that are not bridged yet
    bool reversed_ = false;

    std::vector<uint32_t> queue_; // nodes that may be ears; entries before head_ are done
    size_t head_ = 0;
    std::vector<Wait> waits_;
    ReflexGrid grid_;
    uint32_t forced_ = 0;
    uint64_t vertex_tests_ = 0;

    RingTriangles triangles_;
    std::vector<uint32_t> bridge_half_edge_; // per bridge: the half-edge of the side that was cut first
    EdgeFlips flips_;
};

} // namespace brittle::fracture::triangulation
