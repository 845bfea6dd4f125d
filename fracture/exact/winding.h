// The winding number of the surface around each Voronoi vertex: 1 inside the solid, 0 outside.
//
// No ray is cast. Along a Voronoi edge the number rises by one at a pierce point where the edge enters the solid and
// falls by one where it leaves; on the box it is zero. Every Voronoi vertex is connected with the box along Voronoi
// edges (cells are convex polytopes, whose corners and edges are connected), so one walk over the diagram finds all
// numbers. A vertex that stands for those of cells outside the solid (diagram.h) counts as one on the box.
//
// A surface that overlaps itself may give any integer: a vertex of winding number w belongs to |w| sheets of the solid,
// each with its own copy of the vertex. The sheets of a vertex with a negative number are inside out.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/cut.h"
#include "fracture/exact/predicates.h"
#include "fracture/exact/voronoi.h"

namespace brittle::fracture::exact {

// The winding numbers, and the nodes of the Voronoi vertices.
struct Winding {
    std::vector<uint32_t> pierce_begin; // per Voronoi edge, and the end: into pierces
    std::vector<uint32_t> pierces;      // the pierce points of each Voronoi edge, along its direction
    std::vector<int32_t> of_vertex;     // the winding number of each Voronoi vertex
    std::vector<uint32_t> first_node;   // per vertex, and the end: the nodes of its sheets
    bool consistent = true;             // false where the surface is not closed

    // The sheets at winding number w are 1 to w, or w + 1 to 0 where w is negative.
    [[nodiscard]] static bool has_sheet(int32_t w, int32_t sheet) { return sheet > 0 ? w >= sheet : w < sheet; }
    [[nodiscard]] uint32_t node(uint32_t vertex, int32_t sheet) const {
        return first_node[vertex] + static_cast<uint32_t>(sheet > 0 ? sheet - 1 : -sheet);
    }
    [[nodiscard]] std::span<const uint32_t> pierces_of(uint32_t voronoi_edge) const {
        return std::span(pierces).subspan(pierce_begin[voronoi_edge],
                                          pierce_begin[voronoi_edge + 1] - pierce_begin[voronoi_edge]);
    }

    // Fills all members, and cut.nodes.
    void compute(const Scene& scene, const VoronoiDiagram& diagram, std::span<const Triangle> triangles, Cut& cut,
                 Threads& threads, PredicateStats& stats);

  private:
    void group_by_edge(const VoronoiDiagram& diagram, const Cut& cut);
    void spread(const VoronoiDiagram& diagram, const Cut& cut);
    void make_nodes(const VoronoiDiagram& diagram, Cut& cut);
    void sort_edge(const Scene& scene, const VoronoiDiagram& diagram, std::span<const Triangle> triangles,
                   const Cut& cut, uint32_t voronoi_edge, PredicateStats& stats);

    std::vector<uint32_t> edge_of_vertex_begin_, edges_of_vertex_, queue_;
};

} // namespace brittle::fracture::exact
