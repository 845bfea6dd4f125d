// Cuts the mesh's edges: every edge whose ends lie in different cells is walked from cell to cell, once.
//
// From cell c the walk leaves through the bisector that the edge meets first, of those with the far end
// beyond them; two bisectors are compared by side2. No parameter along the edge is ever compared with
// another.
//
// Where a classifier knows that an edge runs through two cells only, there is nothing to walk.
//
// An edge is walked by the triangle that runs it from the lower vertex to the higher; the triangle on the
// other side finds the points in a hash table. A closed, oriented, manifold mesh has exactly one of each.
#pragma once

#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/cut.h"
#include "fracture/exact/frames.h"

namespace brittle::fracture::exact {

class EdgeCutter {
  public:
    // cut.crossing names the triangles; fills their first and count, and the edge points. The surface is closed,
    // oriented and manifold (surface.h).
    void run(const Scene& scene, const VoronoiDiagram& diagram, const Frames& frames,
             std::span<const Triangle> triangles, std::span<const SiteId> cell_of, Threads& threads, Cut& cut,
             PredicateStats& stats);

  private:
    struct Walk { // of one edge, by its owner
        uint64_t key;
        uint32_t first, count; // in the chunk until numbered
    };
    struct Chunk {
        std::vector<Walk> walks;
        std::vector<EdgePoint> points;
        std::vector<glm::dvec3> positions;
        std::vector<double> beyond; // values of one cell's planes at the far end
        PredicateStats stats;
        uint32_t base = 0;
    };

    void walk_edge(const Scene& scene, const VoronoiDiagram& diagram, const Frames& frames, uint32_t low, uint32_t high,
                   SiteId from, SiteId to, Chunk& chunk) const;
    // The edge meets one bisector, that of the cells of its ends. False where they have none: a classifier that errs.
    [[nodiscard]] static bool cross_once(const Scene& scene, const VoronoiDiagram& diagram, const Frames& frames,
                                         uint32_t low, uint32_t high, SiteId from, SiteId to, Chunk& chunk);
    void insert(const Walk& walk);
    [[nodiscard]] const Walk& find(uint64_t key) const; // which is there

    std::vector<Chunk> chunks_;
    std::vector<Walk> table_; // open addressing, key 0 is free
};

} // namespace brittle::fracture::exact
