// Cuts the triangles of the mesh: a crossing triangle falls into one convex polygon for each cell that it meets.
//
// Most triangles need no arithmetic. Where the edges carry two points in all, both belong to one bisector, and the
// triangle falls into a triangle and a quad, the case of the paper's equations 8 to 13. (A third cell inside would
// touch the two others along one straight segment each; no convex polygon does that.) Where a classifier reports that
// three cells meet inside the triangle and no other cell reaches it, the triangle falls into three quads around that
// point.
//
// Any other triangle is clipped by the bisectors of its first corner's cell, then by those of the cells across the new
// edges, until no cell is left. A polygon is a cyclic list of lines, and a corner is a pair of lines; side1, side2 and
// side3 give the sign of a corner against a bisector. So all cells find the same corners, which have their ids already
// or receive them here.
#pragma once

#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/cut.h"
#include "fracture/exact/frames.h"

namespace brittle::fracture::exact {

class TriangleCutter {
  public:
    // Fills the pierce points, the polygons and the `next` of all points. Runs after EdgeCutter::run().
    void run(const Scene& scene, const VoronoiDiagram& diagram, const Frames& frames,
             std::span<const Triangle> triangles, std::span<const SiteId> cell_of, Threads& threads, Cut& cut,
             PredicateStats& stats);

  private:
    class Worker;
    std::vector<Worker> workers_;

  public:
    TriangleCutter();
    ~TriangleCutter();
};

} // namespace brittle::fracture::exact
