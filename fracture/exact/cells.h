// One Voronoi cell inside a box, made by clipping the box with bisectors in order of distance.
//
// The cell is stored as its dual triangulation: a vertex is a triple of planes, counter-clockwise as seen from outside,
// with links to the three adjacent vertices. Clipping removes the vertices beyond the new plane and joins the rim of
// the hole to it. The predicate side4, exact and perturbed, decides which vertices are beyond. So each vertex has
// exactly three planes, and all cells agree about their common facets, edges and vertices. Coordinates serve the filter
// only.
//
// Security radius: a site farther away than twice the farthest vertex cannot cut the cell (Levy and Bonneel,
// "Variational anisotropic surface meshing with Voronoi parallel linear enumeration", 2013). More precisely, a site
// cuts off vertex v only from inside the ball around v through c. The box around all these balls excludes most of the
// inner sites from cells at the border of the diagram, which reach far outwards.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "fracture/exact/predicates.h"
#include "fracture/exact/site_tree.h"

namespace brittle::fracture::exact {

class CellBuilder {
  public:
    // Builds the cell of site c and discards the cell before. Returns false for an empty cell: c is a duplicate, the
    // cell lies outside the box, or heavier sites take all of it.
    bool build(const Diagram& diagram, const SiteTree& tree, SiteId c);

    // The planes that bound the cell, in ascending order; the sides of the box come last.
    [[nodiscard]] std::span<const PlaneId> planes() const { return used_planes_; }
    // Three indices into planes() for each vertex, counter-clockwise as seen from outside.
    [[nodiscard]] std::span<const std::array<uint32_t, 3>> vertices() const { return used_vertices_; }

    // A box around the facet on a plane, given by its index in planes(), in scene coordinates. Infinite where the position
    // of a vertex is unreliable.
    [[nodiscard]] Box facet_box(uint32_t plane) const;

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
    double advantage_ = 0.0; // the greatest weight minus the weight of c, >= 0; squared radii of the balls grow by it

    // All planes tried so far, in the cell or not. Vertices refer to planes by slot, an index into these arrays.
    std::vector<PlaneId> plane_id_;
    std::vector<Bisector> plane_;

    // Vertices, as arrays for the vectorised filter: the position in the frame of c, and two factors of the error bound
    // |h| * ew + |n| * ex. The factors are infinite where the position is unreliable.
    std::vector<double> x_, y_, z_, ew_, ex_;
    std::vector<std::array<uint32_t, 3>> corner_; // plane slots (a,b,d)
    std::vector<std::array<uint32_t, 3>>
        beside_; // [e]: the vertex at the other end of the edge between planes e, e + 1
    uint32_t count_ = 0;
    uint32_t unreliable_ = 0; // number of vertices with infinite error factors

    std::vector<double> value_, bound_;
    std::vector<uint8_t> is_removed_;
    std::vector<uint32_t> removed_;
    struct RimEdge {
        uint32_t p, q;   // plane slots, in the order of the removed triangle
        uint32_t kept;   // the vertex beyond the rim
        uint32_t corner; // of `kept`: the index of its edge (q, p)
        uint32_t added;  // the new vertex (p, q, new plane)
    };
    std::vector<RimEdge> rim_;
    std::vector<uint32_t> at_plane_; // per slot: the new vertex with this first plane
    SiteTree::WalkMemory walk_memory_;

    std::vector<PlaneId> used_planes_;
    std::vector<std::array<uint32_t, 3>> used_vertices_;
    std::vector<uint32_t> slot_order_, slot_rank_;
};

} // namespace brittle::fracture::exact
