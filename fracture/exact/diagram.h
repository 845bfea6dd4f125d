// Builds the Voronoi diagram from the cells of its sites.
//
// Each facet (i,j), i < j, is described by cell i; each edge and vertex belongs to the facet of its two
// lowest sites. So every item has one owner, and ids follow from prefix sums over owners: no hash table, no
// order of threads.
#pragma once

#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/cells.h"
#include "fracture/exact/predicates.h"
#include "fracture/exact/voronoi.h"

namespace brittle::fracture::exact {

class DiagramBuilder {
  public:
    // In the coordinates of the predicates (scene.h). Reuses the memory of `out` and of earlier calls.
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
        std::vector<uint32_t> fan_begin; // per plane of one cell, into fan
        std::vector<std::array<uint32_t, 2>> fan;
        // The owned facets' thirds, one facet after the other: indices into the cell's planes.
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
    std::vector<uint32_t> facet_begin_;  // sites + 1: the facets that each cell owns
    std::vector<uint32_t> edge_begin_;   // facets + 1
    std::vector<uint32_t> vertex_begin_; // facets + 1
};

// The position of the Voronoi vertex of these ascending planes, always computed in the frame of the first
// site.
[[nodiscard]] glm::dvec3 vertex_position(const Diagram& problem, const std::array<PlaneId, 4>& planes);

} // namespace brittle::fracture::exact
