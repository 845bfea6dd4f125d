// Cuts a small part of a large mesh, in time that depends on the part: the blow that chips a wall need not read it all.
//
//     std::optional<LocalCut> cut = LocalCut::make(mesh, sites, groups, rest, settings);
//     if (!cut) { ... }                         // cut the whole mesh instead
//     merge_pieces(cut->cells, goes_to, threads);
//     for (const LocalCut::Rest& part : cut->rest(mass, tag_of)) ...
//
// Sites of one group, the rest, have cells that stay together. The cells of all other sites must lie in a small region.
// Only the triangles near it are cut, closed to a solid by lids (lids.h); the pieces in the region are those of a cut
// of the whole mesh. Pieces of the rest that hold lids are open pieces: what continues in triangles that were not cut.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <unordered_set>
#include <vector>

#include "fracture/local/cluster_mesh.h"
#include "fracture/local/number_table.h"
#include "fracture/pieces/fragments.h"
#include "fracture/settings.h"

namespace brittle::fracture {

class LocalCut {
  public:
    // Precondition: the mesh is a closed manifold, oriented and connected; groups has one entry a site; the wavelength
    // of rough cuts is not 0. Of the settings reads threads, rough, cancelled and work_log. Returns nothing where the
    // caller must cut the whole mesh: the cells reach far out or over most of the mesh, no lids were found, the cut of
    // the patch failed, or it was cancelled.
    [[nodiscard]] static std::optional<LocalCut> make(const ClusterMesh& mesh, std::span<const glm::dvec3> sites,
                                                      std::span<const uint32_t> groups, uint32_t rest,
                                                      const Settings& settings);

    // The pieces, as of fracture() with these sites. triangle_source of an exterior triangle is an index into tags().
    // Open pieces have an infinite volume, and no other mass properties. A splinter where the surface passes through
    // itself may have a negative volume.
    Fragments cells;

    // By triangle that was cut: its tag in the mesh.
    [[nodiscard]] const std::vector<uint32_t>& tags() const { return tags_; }
    // The sites that bound the region, with those in it, as indices into all sites.
    [[nodiscard]] const std::vector<uint32_t>& near_sites() const { return near_sites_; }
    // Whether a piece of `cells`, merged or not, is open.
    [[nodiscard]] bool is_open(const Piece& piece) const;

    struct Rest {
        ClusterMesh mesh;
        MassProperties mass;
    };
    // What remains of the mesh: the triangles that were not cut, and those of the open pieces of `cells` but for lids.
    // One mesh for each part that hangs together, the largest first. tag_of(t, exterior) gives the tag of triangle t of
    // `cells`; `before` is the mass of the mesh. Returns nothing where the remains are not closed, or where a part is a
    // cavity.
    [[nodiscard]] std::vector<Rest> rest(const MassProperties& before,
                                         const std::function<uint32_t(uint32_t, bool)>& tag_of) const;

  private:
    LocalCut() = default;
    [[nodiscard]] static std::vector<Rest> separated(Rest all);
    [[nodiscard]] bool take_patch(const ClusterMesh& mesh, const Box& region, TriangleMesh& patch);
    [[nodiscard]] bool close_patch(const Box& region, TriangleMesh& patch);
    [[nodiscard]] bool cut_patch(const TriangleMesh& patch, const Box& region, std::span<const glm::dvec3> sites,
                                 std::span<const uint32_t> groups, uint32_t rest, const Settings& settings);

    ClusterMesh mesh_;
    std::vector<uint32_t> near_sites_;
    ClusterSet opened_;       // the clusters that hold triangles of the patch
    FaceList kept_;           // the other triangles of those clusters, by vertex numbers of the mesh
    NumberTable kept_number_; // the index in kept_ of a vertex number
    std::vector<uint32_t> tags_;
    TriangleMesh taken_;                        // the patch, without lids
    std::vector<Triangle> outer_;               // triangles of the patch that have a vertex on its border
    std::vector<uint8_t> inner_;                // by vertex of the patch: 1 where all of its triangles are in the patch
    std::vector<uint32_t> numbers_;             // by vertex of the patch: its number in the mesh; no_index in lids
    std::vector<uint32_t> border_;              // by vertex of the patch: its index on the border, or no_index
    uint32_t border_size_ = 0;                  // vertices on the border, by number
    std::unordered_set<uint64_t> border_edges_; // by vertex numbers of the mesh
};

} // namespace brittle::fracture
