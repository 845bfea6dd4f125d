// Cuts the edges of the mesh: follows every edge with ends in different cells from cell to cell, once.
//
// Among the bisectors of the current cell with the far end beyond them, the edge leaves the cell through the one that
// it meets first; side2 compares two bisectors. Parameters along the edge are never compared with each other. An edge
// that runs through two cells only, as reported by a classifier, needs no search.
//
// The triangle that runs an edge from the lower to the higher vertex owns it; the triangle on the other side finds the
// points in a hash table. In a closed, oriented, manifold mesh each edge has exactly one owner.
#pragma once

#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/cut.h"
#include "fracture/exact/frames.h"

namespace brittle::fracture::exact {

class EdgeCutter {
  public:
    // Cuts the edges of the triangles in cut.crossing. Fills their `first` and `count`, and the edge points. The
    // surface is closed, oriented and manifold (surface.h).
    void run(const Scene& scene, const VoronoiDiagram& diagram, const Frames& frames,
             std::span<const Triangle> triangles, std::span<const SiteId> cell_of, Threads& threads, Cut& cut,
             PredicateStats& stats);

  private:
    struct Walk { // the points of one edge
        uint64_t key;
        uint32_t first, count; // indices into Chunk::points, then into Cut::edge_points
    };
    struct Chunk {
        std::vector<Walk> walks;
        std::vector<EdgePoint> points;
        std::vector<glm::dvec3> positions;
        std::vector<double> beyond; // values of one cell's planes at the far end of an edge
        PredicateStats stats;
        uint32_t base = 0;
    };

    void walk_edge(const Scene& scene, const VoronoiDiagram& diagram, const Frames& frames, uint32_t low, uint32_t high,
                   SiteId from, SiteId to, Chunk& chunk) const;
    // Cuts an edge that meets only the bisector of its two ends' cells. Returns false, with nothing done, where these
    // cells have no common facet: the classifier was wrong.
    [[nodiscard]] static bool cross_once(const Scene& scene, const VoronoiDiagram& diagram, const Frames& frames,
                                         uint32_t low, uint32_t high, SiteId from, SiteId to, Chunk& chunk);
    void insert(const Walk& walk);
    [[nodiscard]] const Walk& find(uint64_t key) const; // the key is in the table

    std::vector<Chunk> chunks_;
    std::vector<Walk> table_; // open addressing, key 0 is free
};

} // namespace brittle::fracture::exact
