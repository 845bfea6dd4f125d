// One Voronoi cell inside a box, by clipping the box with bisectors in order of distance.
//
// The cell is kept as its dual triangulation: a vertex is a triple of planes, counter-clockwise seen from
// outside, and knows the three vertices beside it. Clipping removes the vertices beyond the new plane and
// joins the rim of the hole to it. Which vertices are beyond is decided by side4, exact and perturbed, so the
// cell is always simple (three planes a vertex) and all cells agree about their common facets, edges and
// vertices. Coordinates only serve the filter.
//
// Security radius: a site farther than twice the farthest vertex cannot cut. (Levy and Bonneel, "Variational
// anisotropic surface meshing with Voronoi parallel linear enumeration", 2013.) More exactly, a site cuts
// vertex v only from inside the ball around v through c; the box around all these balls spares cells at the
// border of the diagram, which reach far outwards, most of the sites inwards.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "fracture/exact/predicates.h"
#include "fracture/exact/site_tree.h"

namespace brittle::fracture::exact {

class CellBuilder {
  public:
    // Builds the cell of c, replacing the one before. False where it is empty: c is a duplicate, the cell
    // lies outside the box altogether, or heavier sites leave nothing to it.
    bool build(const Diagram& diagram, const SiteTree& tree, SiteId c);

    // The planes that bound the cell, ascending (sides of the box come last).
    [[nodiscard]] std::span<const PlaneId> planes() const { return used_planes_; }
    // Indices into planes(), counter-clockwise seen from outside.
    [[nodiscard]] std::span<const std::array<uint32_t, 3>> vertices() const { return used_vertices_; }

    PredicateStats stats;

  private:
    enum class Cut { none, some, all };

    void start_with_box();
    Cut cut(SiteId site);
    Cut find_removed(const Bisector& l, SiteId site);
    void replace_removed(uint32_t new_slot);
    void erase(uint32_t hole);
    void place_vertex(uint32_t v, uint32_t a, uint32_t b, uint32_t d);
    [[nodiscard]] double security2() const;
    [[nodiscard]] SiteTree::Reach reach() const;
    void collect();

    const Diagram* diagram_ = nullptr;
    SiteId c_ = 0;
    double advantage_ = 0.0; // by how much the greatest weight of all exceeds that of c; balls grow by it

    // Planes met so far, used or not; vertices name them by slot.
    std::vector<PlaneId> plane_id_;
    std::vector<Bisector> plane_;

    // Vertices, as arrays for the vectorised filter: position in the frame of c, and the factors of the error
    // bound |h| * ew + |n| * ex; infinite where the position is meaningless.
    std::vector<double> x_, y_, z_, ew_, ex_;
    std::vector<std::array<uint32_t, 3>> corner_; // plane slots (a,b,d)
    std::vector<std::array<uint32_t, 3>> beside_; // [e]: the vertex at the other end of the edge between planes e, e+1
    uint32_t count_ = 0;
    uint32_t unreliable_ = 0; // vertices whose position may be far off

    std::vector<double> value_, bound_;
    std::vector<uint8_t> is_removed_;
    std::vector<uint32_t> removed_;
    struct RimEdge {
        uint32_t p, q;   // plane slots, directed as in the removed triangle
        uint32_t kept;   // vertex beyond the rim
        uint32_t corner; // the edge (q,p) in it
        uint32_t added;  // the new vertex (p, q, new plane)
    };
    std::vector<RimEdge> rim_;
    std::vector<uint32_t> at_plane_; // slot -> the new vertex whose first plane it is
    SiteTree::WalkMemory walk_memory_;

    std::vector<PlaneId> used_planes_;
    std::vector<std::array<uint32_t, 3>> used_vertices_;
    std::vector<uint32_t> slot_order_, slot_rank_;
};

} // namespace brittle::fracture::exact
