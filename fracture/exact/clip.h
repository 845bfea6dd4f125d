// Cuts the mesh's triangles: each crossing triangle falls into one convex polygon for each cell that it
// meets.
//
// A triangle whose edges carry two points in all meets one bisector and needs no arithmetic: it falls into a
// triangle and a quad. (Two points on the border belong to one bisector; a third cell inside would have to
// touch the two others along single straight segments, which no convex polygon does.) This is the case of the
// paper's equations 8 to 13. Where a classifier knows that three cells meet inside the triangle and no other
// reaches it, it falls into three quads around that point. Any other triangle is clipped by the bisectors of the cell of its first corner,
// then by those of the cells on the other side of the edges that came out, until none is left. A polygon
// under the knife is a cyclic list of lines; its corners are pairs of lines, and the sign of a corner against
// a bisector is side1, side2 or side3. So all cells of the triangle find the same corners, and these already
// have, or here receive, their ids.
#pragma once

#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/cut.h"
#include "fracture/exact/frames.h"

namespace brittle::fracture::exact {

class TriangleCutter {
  public:
    // After EdgeCutter::run(). Fills the pierce points, the polygons and the `next` of all points.
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
