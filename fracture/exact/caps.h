// Caps the cuts: triangulates the part of each Voronoi facet that lies inside the solid, once for both cells.
//
// Two kinds of polyline bound this part. Chains run where the surface of the mesh crosses the facet (the triangle
// cutter stores them in the `next` of each point). Strands are the intervals of the facet's own edges that lie inside
// the solid. The walk once around the facet carries the winding number: a strand of sheet s begins where the number
// rises to s and ends where it falls below s. A chain ends at the point where a strand begins, so chains and strands
// alternate and form closed loops, without any search. A surface that overlaps itself or is inside out gives one set of
// loops for each sheet. The border walk of the paper, section 2.3, cuts with whole planes and so needs no strands.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/cut.h"
#include "fracture/exact/edge_nodes.h"
#include "fracture/exact/voronoi.h"
#include "fracture/exact/winding.h"
#include "fracture/triangulation/interior_points.h"
#include "fracture/triangulation/triangulate.h"

namespace brittle::fracture::exact {

// A diagonal of a cap must not join two points of one Voronoi edge: the caps on the other two facets of the edge have
// points there too, and an edge of the surface would be used twice. In sound input a diagonal along a side of the facet
// is rare; in overlapping surfaces it occurs. Such a diagonal is split by a node of its own.

// The cap of one facet, counter-clockwise as seen from outside the cell with the lower index.
struct Cap {
    uint32_t facet;
    uint32_t corners_begin, corners_end;     // into CapChunk::corners
    uint32_t triangles_begin, triangles_end; // into CapChunk::triangles
};

// Points on the edges of facets and inside them, for caps that are bent after the cut (rough/rough.h).
struct CapLattice {
    double spacing = 0.0; // of the points, m; 0 for none
    // Where the vertices of the mesh will be after the bend. Caps avoid triangles with all corners in one plane there.
    std::span<const glm::dvec3> places{};
    // One group a site, or empty. Facets between sites of one group get no points, as their pieces will be merged.
    std::span<const uint32_t> groups{};

    [[nodiscard]] bool is_bent(uint32_t i, uint32_t j) const { return groups.empty() || groups[i] != groups[j]; }
};

struct CapChunk {
    struct AddedNode {
        uint32_t facet;
        glm::dvec3 position;
    };

    std::vector<Cap> caps;
    std::vector<AddedNode> added_nodes; // numbered after the nodes of the Voronoi vertices
    std::vector<VertexId> corners;
    std::vector<Triangle> triangles; // indices relative to the first corner of the cap
};

// The position of a corner of a cap, in scene coordinates.
[[nodiscard]] glm::dvec3 cap_position(const Cut& cut, VertexId id);

class Capper {
  public:
    // Makes the caps of all facets. Runs after TriangleCutter::run() and Winding::compute(), and may append to
    // cut.nodes. Returns false where the loops do not close, which a closed surface rules out.
    bool run(const Scene& scene, const VoronoiDiagram& diagram, const Winding& winding,
             std::span<const Triangle> triangles, const CapLattice& lattice, Cut& cut, Threads& threads);

    // In ascending order of facets.
    [[nodiscard]] std::span<const CapChunk> chunks() const { return {chunks_.data(), chunk_count_}; }
    [[nodiscard]] uint64_t forced_ears() const;

  private:
    class Worker;
    void find_normals(std::span<const Triangle> triangles, const CapLattice& lattice, const Cut& cut);
    void number_added_nodes(const VoronoiDiagram& diagram, Cut& cut);
    void group_by_facet(const VoronoiDiagram& diagram, const Cut& cut);

    EdgeNodes edge_nodes_;
    std::vector<InteriorPoints::Normals> edge_normals_, pierce_normals_; // per edge point, per pierce point
    std::vector<uint32_t> points_begin_;                                 // per facet, and the end: into points_
    std::vector<uint32_t> points_;                                       // the edge points of each facet
    std::vector<uint8_t> visited_;                                       // per edge point
    std::vector<CapChunk> chunks_;
    std::vector<Worker> workers_;
    uint32_t chunk_count_ = 0;

  public:
    Capper();
    ~Capper();
};

} // namespace brittle::fracture::exact
