// Rough cuts: the exact fracture of a warped solid, taken back.
//
// "Real Time Voronoi Fracturing of Polygon Meshes", section 1, asks for cuts that are not flat. A smooth one-to-one map
// of space (warp.h) is applied to the surface and to the sites; the exact core cuts the result by planes, so every
// decision stays exact; and each point is taken back by what it is (restore.h). Both sides of a cut share their points,
// so the pieces are closed and their volumes add up, whatever the noise. The border of a cut bends on the surface too,
// because triangles near a cut are divided before (refine.h).
//
//     RoughCut rough;
//     rough.start(mesh, sites, settings);
//     rough.run(mesh, sites, settings, scratch, choose, pieces);
//
// The outside of the pieces is the surface of the input, to the last bit of each vertex. Close to it, a cut follows the
// warp up to an error of second order in the spacing, and may cross the surface. There the warp is calmed, and the
// solid is cut again.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "fracture/exact/bonds.h"
#include "fracture/exact/exact.h"
#include "fracture/rough/crossings.h"
#include "fracture/rough/refine.h"
#include "fracture/rough/restore.h"
#include "fracture/rough/warp.h"

namespace brittle::fracture::rough {

// The typical distance of adjacent sites, m: the geometric mean of the one among the sites and the one that a point of
// the surface sees, which differ where small cells crowd around a blow. 0 where there are not two different sites.
// Precondition: the indices of the mesh are in range.
[[nodiscard]] double typical_distance(const TriangleMesh& mesh, std::span<const glm::dvec3> sites);

// Errors: invalid_setting for a value out of its range (settings.h).
[[nodiscard]] Result<void> check(const Roughness& roughness);

// Reuses its memory. Not synchronised.
class RoughCut {
  public:
    // Chooses the warp and the spacing of points.
    void start(const TriangleMesh& mesh, std::span<const glm::dvec3> sites, const Settings& settings);
    // The same for a part of a solid, in a box, that so many sites cut. `far` is 1, by vertex of the part's mesh, where
    // no cut comes near; it must outlive run(). Precondition: the wavelength is not 0, and the mesh's indices are in
    // range.
    void start(const Box& solid, size_t site_count, const Settings& settings, std::span<const uint8_t> far);

    // The representative of each piece (merge.h), or nothing where no pieces merge; pieces are in their places. `flakes`
    // is 1, by piece, where a cut that grazes the surface has left a flake, whose volume is nearly zero or negative, and
    // which a neighbour must absorb; empty where there is none.
    using Choice = std::function<std::vector<uint32_t>(std::vector<uint8_t> flakes)>;

    // Cuts, merges and places the pieces. Throws Threads::Cancelled. Errors: as exact::fracture_exact(), in terms of
    // `mesh`.
    [[nodiscard]] Result<void> run(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                   const Settings& settings, exact::Scratch& scratch, const Choice& choose,
                                   Fragments& out);

    // That of the last cut.
    [[nodiscard]] const Warp& warp() const { return warp_; }
    // The triangle of the mesh that holds an exterior triangle, by its triangle_source, while pieces are chosen.
    [[nodiscard]] uint32_t source_of(uint32_t part) const {
        return surface_.source.empty() ? part : surface_.source[part];
    }

  private:
    // Cuts the warped solid.
    [[nodiscard]] Result<void> cut(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                   const Settings& settings, exact::Scratch& scratch, Fragments& out);
    // Moves the points of the pieces, merged or not, to their places, and computes masses and bonds there: what decides
    // which pieces to merge. Returns the flakes.
    std::vector<uint8_t> place(size_t site_count, Fragments& pieces);
    // Moves the points back to where they were cut, for merging: only there do pieces meet as the cut decided.
    void warp_back(Fragments& pieces);
    // Joins the parts of the outside's triangles, in pieces that are in their places.
    void join(const TriangleMesh& mesh, Fragments& pieces);
    // Looks for cuts that cross their piece. Returns true where the warp has been calmed around them and the solid must
    // be cut again; sets pieces.crossings otherwise.
    [[nodiscard]] bool calm(const Settings& settings, Fragments& pieces);
    void weigh(Fragments& pieces);
    void begin(const Settings& settings);
    void choose_spacing(const Box& box, size_t site_count, const Roughness& roughness);

    Threads threads_{1};
    uint32_t requested_threads_ = 1;
    bool in_range_ = false; // the indices of the mesh
    Roughness roughness_;
    double wavelength_ = 0.0;
    double spacing_ = 0.0; // of the points on the cuts and their borders, m; 0 for none
    std::vector<CalmBall> calm_balls_;
    CrossingFinder crossing_finder_;
    uint32_t rounds_ = 0; // of calm()
    std::span<const uint8_t> far_;
    Warp warp_;
    std::vector<glm::dvec3> warped_positions_, warped_sites_;
    std::vector<glm::dvec3> cut_positions_; // of the pieces, between place() and warp()
    SurfaceRefiner refiner_;
    Surface surface_;
    Restorer restorer_;
    exact::BondFinder bonds_;
};

} // namespace brittle::fracture::rough
