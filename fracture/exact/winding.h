// How often the surface winds around each Voronoi vertex: 1 inside the solid, 0 outside.
//
// No ray is cast. Along a Voronoi edge the number changes by one at each pierce point, up where the edge
// enters the solid and down where it leaves; on the box it is zero; and every Voronoi vertex is connected
// with the box along Voronoi edges (cells are convex polytopes, whose corners and edges are connected). So
// one walk over the diagram finds all. For a surface that overlaps itself the number may be any integer: a
// vertex of winding w belongs to |w| sheets of the solid, each with a copy of the vertex, and negative sheets
// are inside out.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/cut.h"
#include "fracture/exact/predicates.h"
#include "fracture/exact/voronoi.h"

namespace brittle::fracture::exact {

// compute() also fills cut.nodes.
struct Winding {
    std::vector<uint32_t> pierce_begin; // Voronoi edges + 1, into pierces
    std::vector<uint32_t> pierces;      // pierce points of each Voronoi edge, along its direction
    std::vector<int32_t> of_vertex;
    std::vector<uint32_t> first_node; // vertices + 1: the nodes of a vertex's sheets
    bool consistent = true;           // false: the surface is not closed

    // The sheets present at winding w are those numbered 1 to w, or w + 1 to 0 where w is negative.
    [[nodiscard]] static bool has_sheet(int32_t w, int32_t sheet) { return sheet > 0 ? w >= sheet : w < sheet; }
    [[nodiscard]] uint32_t node(uint32_t vertex, int32_t sheet) const {
        return first_node[vertex] + static_cast<uint32_t>(sheet > 0 ? sheet - 1 : -sheet);
    }
    [[nodiscard]] std::span<const uint32_t> pierces_of(uint32_t voronoi_edge) const {
        return std::span(pierces).subspan(pierce_begin[voronoi_edge],
                                          pierce_begin[voronoi_edge + 1] - pierce_begin[voronoi_edge]);
    }

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
