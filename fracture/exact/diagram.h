// Builds the Voronoi diagram from the cells of its sites.
//
// Cell i describes each facet (i,j) with i < j; each edge and vertex belongs to the facet of its two lowest sites. So
// every item has one owner, and prefix sums over owners give its id, without a hash table and independent of thread
// order.
//
// A cut of a solid needs only the cells that the solid meets. They are found in waves: first the cells of the sites in
// the solid, as far as a coarse grid knows it (solid_grid.h), then the cells beyond each facet that the solid may meet.
// Every point of a connected part of the solid is reached: a path to it in the solid crosses such facets only.
#pragma once

#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/cells.h"
#include "fracture/exact/predicates.h"
#include "fracture/exact/solid_grid.h"
#include "fracture/exact/voronoi.h"

namespace brittle::fracture::exact {

class DiagramBuilder {
  public:
    // Builds in scene coordinates (scene.h). Reuses the memory of `out` and of earlier calls.
    //
    // With `solid`, cells that certainly lie outside it are not built; they are empty in `out`, and a facet with them
    // is none. One vertex and one edge, both on the box, stand for all vertices and edges of these cells. Needs a problem
    // without weights.
    void build(const Diagram& problem, Threads& threads, const SolidGrid* solid, VoronoiDiagram& out);

    // The sites of the last build.
    [[nodiscard]] const SiteTree& tree() const { return tree_; }

    [[nodiscard]] PredicateStats stats() const;

  private:
    struct CellRef {
        uint32_t chunk = 0;
        uint32_t planes_begin = 0, planes_end = 0; // into Chunk::planes
        uint32_t rings_begin = 0;                  // into Chunk::rings
        uint32_t ring_sizes_begin = 0;             // into Chunk::ring_sizes
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
        std::vector<SiteId> found; // cells to build next
    };

    void build_cells(const Diagram& problem, const SolidGrid* solid, Threads& threads, VoronoiDiagram& out);
    void choose_cells(const SolidGrid* solid);
    void build_cell(const Diagram& problem, const SolidGrid* solid, SiteId c, uint32_t chunk_index,
                    VoronoiDiagram& out);
    void number_facets(VoronoiDiagram& out);
    static void collect_rings(SiteId c, Chunk& chunk);
    void number_items(VoronoiDiagram& out);
    void add_outside(VoronoiDiagram& out);
    // The sites around a cell, in ascending order.
    [[nodiscard]] std::span<const PlaneId> neighbours_of(SiteId c) const;
    template<class Visit>
    void visit_owned(SiteId c, const Visit& visit) const;
    [[nodiscard]] bool is_built(PlaneId plane) const { return is_box_plane(plane) || is_chosen_[plane]; }
    // Whether a facet owns the edge that it shares with a third cell.
    [[nodiscard]] bool owns(const VoronoiDiagram::Facet& facet, PlaneId third) const {
        return third > facet.j && is_built(third);
    }
    void fill_owned(const Diagram& problem, SiteId c, VoronoiDiagram& out) const;
    void link_rings(SiteId c, VoronoiDiagram& out) const;
    [[nodiscard]] uint32_t edge_of(const VoronoiDiagram& d, uint32_t facet, PlaneId third) const;
    [[nodiscard]] uint32_t vertex_of(const VoronoiDiagram& d, uint32_t facet, PlaneId a, PlaneId b) const;

    SiteTree tree_;
    std::vector<CellRef> cells_;
    std::vector<Chunk> chunks_;
    std::vector<SiteId> chosen_;         // the cells to build, in waves; the first ones leaf by leaf of the tree
    std::vector<uint8_t> is_chosen_;     // per site
    std::vector<uint32_t> facet_begin_;  // per site, and the end: the first facet that its cell owns
    std::vector<uint32_t> edge_begin_;   // per facet, and the end: the first edge that it owns
    std::vector<uint32_t> vertex_begin_; // per facet, and the end: the first vertex that it owns
    uint32_t outside_vertex_ = VoronoiDiagram::none, outside_edge_ = VoronoiDiagram::none;
};

// The position of the Voronoi vertex of four planes in ascending order. The computation always uses the frame of the
// first site.
[[nodiscard]] glm::dvec3 vertex_position(const Diagram& problem, const std::array<PlaneId, 4>& planes);

} // namespace brittle::fracture::exact
