// Takes the pieces of a warped surface back: to where their points belong in the input, and to its own triangles.
//
// A point is placed by what it is (exact/cut.h), never by its warped coordinates alone. A vertex of the input goes to
// its own position. A point on an edge or a triangle of the surface goes to the same barycentric coordinates there, so
// the outside of the pieces is exactly the surface of the input, whatever the warp. A node inside the solid goes through
// the inverse of the warp. Triangles are straight before and after the warp, so the two ways differ by an error of
// second order in the size of the triangles; nodes beside the surface take part in its error. Each point is placed once,
// for all pieces that meet there.
//
// Then the divided triangles are joined again: the parts of one input triangle in one piece become a polygon, whose
// corners are those of the input and the points of the cuts, and are triangulated anew. So a triangle that no cut
// crosses leaves as it came.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/cut.h"
#include "fracture/pieces/fragments.h"
#include "fracture/rough/refine.h"
#include "fracture/triangulation/interior_points.h"
#include "fracture/triangulation/triangulate.h"

namespace brittle::fracture::rough {

class Restorer {
  public:
    // Computes where the points of a cut of `surface` belong; `pieces` are its pieces, not yet merged, with
    // points of the given spacing on their cuts, m. The other arguments must outlive the calls below.
    void start(const Surface& surface, const exact::Cut& cut, const exact::Scene& scene, const Warp& warp,
               double spacing, const Fragments& pieces, Threads& threads);

    // Returns the place of each vertex of the pieces, in input coordinates.
    [[nodiscard]] std::vector<glm::dvec3> places(const Fragments& fragments, Threads& threads) const;

    // Joins the parts of the input's triangles, in pieces whose vertices are in their places. Sets triangle_source to
    // input triangles and vertex_point to input vertices, and rough_triangles.
    void join_triangles(const TriangleMesh& input, Threads& threads, Fragments& fragments);

  private:
    class Joiner;

    void place_surface_points(Threads& threads);
    void place_nodes(Threads& threads);
    void follow_surface(const Fragments& pieces, Threads& threads);
    void find_inner_edge_points();
    [[nodiscard]] uint64_t count_added(const Fragments& fragments, uint32_t first_added) const;

    const Surface* surface_ = nullptr;
    const exact::Cut* cut_ = nullptr;
    const exact::Scene* scene_ = nullptr;
    const Warp* warp_ = nullptr;
    double spacing_ = 0.0;
    std::vector<uint8_t> is_inner_; // per edge point: 1 on an edge inside a divided input triangle
    std::vector<glm::dvec3> edge_places_, pierce_places_, node_places_;
};

} // namespace brittle::fracture::rough
