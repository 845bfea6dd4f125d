// Divides the triangles of a surface near the cuts, so that the borders of rough cuts can bend on them.
//
// An edge is halved where it is longer than the spacing and a cut passes near it. The decision depends on the edge
// alone, so the two triangles of an edge agree and the surface stays closed. A triangle with one, two or three halved
// edges falls into two, three or four.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "fracture/mesh/mesh.h"
#include "fracture/rough/warp.h"

namespace brittle::fracture::rough {

// The sites after the warp, between whose cells the surface is cut by planes.
struct WarpedSites {
    std::span<const glm::dvec3> positions;
    std::span<const double> weights;  // one per site, or empty
    std::span<const uint32_t> groups; // one per site, or empty: there is no cut within a group
};

// A surface before and after the warp. The first vertices are those of the input.
struct Surface {
    std::vector<glm::dvec3> positions; // in input coordinates
    TriangleMesh warped;
    std::vector<uint32_t> source; // per triangle: the input triangle; empty where no triangle was divided
};

class SurfaceRefiner {
  public:
    // Fills `out` with the surface of the mesh, divided to edges of `spacing`, m. Returns false where that would make
    // more than max_triangles; `out` is unspecified then. Precondition: the indices of the mesh are in range.
    // `warped_positions` are the vertices of the mesh after the warp. An edge stays whole where `far` is 1 at an end;
    // `far` has one entry a vertex, or none.
    bool run(const TriangleMesh& mesh, std::vector<glm::dvec3> warped_positions, std::span<const uint8_t> far,
             const Warp& warp, const WarpedSites& sites, double spacing, size_t max_triangles, Surface& out);

  private:
    struct Part {
        Triangle corners;
        uint32_t candidates_begin, candidates_end;
    };
    void divide(const Part& whole, uint32_t source, Surface& out);
    [[nodiscard]] Part narrow(const Triangle& corners, uint32_t begin, uint32_t end, const Surface& out);
    [[nodiscard]] uint32_t midpoint(uint32_t a, uint32_t b, const Part& part, Surface& out);
    [[nodiscard]] bool is_far(uint32_t vertex) const { return vertex < far_.size() && far_[vertex]; }
    [[nodiscard]] double power(uint32_t site, const glm::dvec3& p) const;
    [[nodiscard]] bool share_group(uint32_t a, uint32_t b) const {
        return a == b || (!sites_.groups.empty() && sites_.groups[a] == sites_.groups[b]);
    }
    [[nodiscard]] bool meets_cut(const glm::dvec3& centre, double radius, const Part& part) const;

    const Warp* warp_ = nullptr;
    std::span<const uint8_t> far_;
    WarpedSites sites_;
    double spacing_ = 0.0;
    size_t max_triangles_ = 0;
    std::vector<uint32_t> candidates_; // sites whose cells may meet a part, one range after the other
    std::vector<Part> parts_;
    std::unordered_map<uint64_t, uint32_t> midpoints_; // of the tested edges; no_index where an edge stays whole
};

} // namespace brittle::fracture::rough
