// Closes the cuts: the part of each Voronoi facet that lies inside the solid, triangulated once for both
// sides.
//
// The border of that part consists of chains, where the surface crosses the facet (made by the triangle
// cutter as the `next` of each point), and of strands, the stretches of the facet's own sides that lie
// inside. Walking once around the facet with the winding number in hand, a strand of sheet s begins where the
// number rises to s and ends where it falls below; chains end where strands begin, so following both gives
// closed loops. Nothing is searched, and overlapping or inside-out surfaces give one set of loops for each
// sheet. This replaces the border walk of the paper's section 2.3, which has no facet sides because it cuts
// with whole planes.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/cut.h"
#include "fracture/exact/voronoi.h"
#include "fracture/exact/winding.h"
#include "fracture/triangulation/triangulate.h"

namespace brittle::fracture::exact {

// No two pieces of surface may use the same edge: a diagonal of a cap must not run between two points of one
// Voronoi edge, where the caps on the other two facets have points too. Triangulations of sound input hardly
// ever hold such a diagonal (it lies on the facet's side); those of overlapping surfaces do. It is then
// halved by a node of its own.

// The cap on one facet: counter-clockwise seen from outside the cell with the lower index.
struct Cap {
    uint32_t facet;
    uint32_t corners_begin, corners_end;     // into CapChunk::corners
    uint32_t triangles_begin, triangles_end; // into CapChunk::triangles
};

struct CapChunk {
    struct AddedNode {
        uint32_t facet;
        glm::dvec3 position;
    };

    std::vector<Cap> caps;
    std::vector<AddedNode> added_nodes; // their ids follow those of the Voronoi vertices' nodes
    std::vector<VertexId> corners;
    std::vector<Triangle> triangles; // of indices that count from the cap's first corner
};

// The position of a cap's corner, in the coordinates of the scene.
[[nodiscard]] glm::dvec3 cap_position(const Cut& cut, VertexId id);

class Capper {
  public:
    // After TriangleCutter::run() and Winding::compute(). May add to cut.nodes. False where the loops do not
    // close, which a closed surface rules out.
    bool run(const Scene& scene, const VoronoiDiagram& diagram, const Winding& winding, Cut& cut, Threads& threads);

    // Facets ascend over the chunks.
    [[nodiscard]] std::span<const CapChunk> chunks() const { return {chunks_.data(), chunk_count_}; }
    [[nodiscard]] uint64_t forced_ears() const;

  private:
    class Worker;
    void number_added_nodes(const VoronoiDiagram& diagram, Cut& cut);
    void group_by_facet(const VoronoiDiagram& diagram, const Cut& cut);

    std::vector<uint32_t> points_begin_; // facets + 1, into points_
    std::vector<uint32_t> points_;       // edge points of each facet
    std::vector<uint8_t> visited_;       // edge points
    std::vector<CapChunk> chunks_;
    std::vector<Worker> workers_;
    uint32_t chunk_count_ = 0;

  public:
    Capper();
    ~Capper();
};

} // namespace brittle::fracture::exact
