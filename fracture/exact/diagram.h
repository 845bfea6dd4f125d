// Builds the Voronoi diagram from the cells of its sites.
//
// Cell i describes each facet (i,j) with i < j; each edge and vertex belongs to the facet of its two lowest sites. So
// every item has one owner, and prefix sums over owners give its id, without a hash table and independent of thread
// order.
#pragma once

#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/cells.h"
#include "fracture/exact/predicates.h"
#include "fracture/exact/voronoi.h"

namespace brittle::fracture::exact {

class DiagramBuilder {
  public:
    // Builds in scene coordinates (scene.h). Reuses the memory of `out` and of earlier calls.
    void build(const Diagram& problem, Threads& threads, VoronoiDiagram& out);

    [[nodiscard]] PredicateStats stats() const;

  private:
    struct CellRef {
        uint32_t chunk = 0;
        uint32_t planes_begin = 0, planes_end = 0; // into Chunk::planes
    };
    struct Chunk {
        CellBuilder builder;
        std::vector<PlaneId> planes;
        std::vector<uint32_t> fan_begin; // per plane of one cell: into fan
        std::vector<std::array<uint32_t, 2>> fan;
        // The thirds (VoronoiDiagram::Corner) of the owned facets, one facet after the other, as indices into the
        // planes of the cell.
        std::vector<uint32_t> rings;
        std::vector<uint32_t> ring_sizes;
    };

    void build_cells(const Diagram& problem, Threads& threads, VoronoiDiagram& out);
    void number_facets(VoronoiDiagram& out);
    static void collect_rings(SiteId c, Chunk& chunk);
    void number_items(VoronoiDiagram& out);
    void fill_owned(const Diagram& problem, SiteId begin, SiteId end, VoronoiDiagram& out) const;
    void link_rings(const Chunk& chunk, SiteId begin, SiteId end, VoronoiDiagram& out) const;
    [[nodiscard]] uint32_t edge_of(const VoronoiDiagram& d, uint32_t facet, PlaneId third) const;
    [[nodiscard]] uint32_t vertex_of(const VoronoiDiagram& d, uint32_t facet, PlaneId a, PlaneId b) const;

    SiteTree tree_;
    std::vector<CellRef> cells_;
    std::vector<Chunk> chunks_;
    std::vector<uint32_t> facet_begin_;  // per site, and the end: the first facet that its cell owns
    std::vector<uint32_t> edge_begin_;   // per facet, and the end: the first edge that it owns
    std::vector<uint32_t> vertex_begin_; // per facet, and the end: the first vertex that it owns
};

// The position of the Voronoi vertex of four planes in ascending order. The computation always uses the frame of the
// first site.
[[nodiscard]] glm::dvec3 vertex_position(const Diagram& problem, const std::array<PlaneId, 4>& planes);

} // namespace brittle::fracture::exact
