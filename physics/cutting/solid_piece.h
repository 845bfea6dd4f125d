// One piece of a breakable object: its closed mesh, mass, collision hulls and strength. A SolidPiece is made once, on
// any thread, and is immutable and shared from then on.
//
//     Result<SolidPtr> whole = make_solid(mesh, {.material = stone});
//     Result<std::vector<SolidPtr>> pieces = break_solid(**whole, sites, groups, settings);
//
// All pieces of an object keep the coordinates of the unbroken object, however often they are cut: double precision for
// the mesh, and single precision relative to the centre of mass for drawing. Metres, kilograms.
//
// Pure functions, for worker threads; results depend on neither the number of threads nor a clock.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "fracture/local/cluster_mesh.h"
#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "fracture/settings.h"
#include "physics/bonds/anchor.h"
#include "physics/bonds/held_blocks.h"
#include "physics/cutting/convex_parts.h"
#include "physics/material.h"
#include "physics/world/piece_mass.h"

namespace brittle::physics {

struct SolidSettings {
    Material material{};
    bool breakable = true; // false: blows move it, but never cut it
    // m, cube root of the minimum volume of a piece. A smaller one joins a neighbour; only a piece
    // without a neighbour may be smaller. A solid below twice the minimum volume is not cut.
    double min_size = 0.05;
    std::vector<AnchorRegion> anchors{}; // in the object's coordinates; a piece that reaches into one is fixed
    ConvexPartSettings parts{};
    HeldBlockSettings blocks{}; // of anchored, breakable solids
    // Of the cuts of blows and loads. A blow has a seed of its own. With a wavelength of 0 the bumps are as large as the
    // pieces of each blow. Splinters turn the grain along the longest axis of the solid that is hit. Where the sites of
    // a blow are closer than three times min_size, its cuts are flat.
    fracture::Roughness rough{};
    uint32_t threads = 1; // of one cut; the jobs of a Destruction use one each
    // Of the collision hulls of one cut (job_threads.h); 0: one a core, at most four. The jobs of a Destruction use them
    // too. Where cores are busy with frames, these threads wait as the job does.
    uint32_t hull_threads = 0;
};

// The surface of a solid as arrays.
struct SolidSurface {
    fracture::TriangleMesh mesh{};      // closed; an unbreakable piece keeps its triangles and drops its positions
    uint32_t exterior_triangles = 0;    // the leading triangles, which lie on the surface of the unbroken object
    std::vector<uint32_t> source{};     // by exterior triangle: the triangle of the unbroken object that holds it
    std::vector<uint32_t> cut{};        // by interior triangle: a number that all triangles of one cut share
    std::vector<glm::vec3> positions{}; // of the vertices, relative to the centre of mass, for drawing
};

class SolidPiece {
  public:
    // The surface. The first call makes the arrays of a solid that has only clusters; from any thread.
    [[nodiscard]] const SolidSurface& surface() const;
    // Both before the solid is shared. Only cuts need the exact positions and the clusters.
    void set_surface(SolidSurface surface);
    void drop_cut_data();
    // These functions make no arrays. The number of vertices of a clustered surface is an estimate: that of a closed
    // surface without holes, half the triangles plus two.
    [[nodiscard]] size_t triangle_count() const;
    [[nodiscard]] size_t vertex_count() const;
    [[nodiscard]] bool is_clustered() const { return clusters.triangle_count() > 0; }
    // Whether a section of a held piece may break under load, or under a blow elsewhere.
    [[nodiscard]] bool may_part() const { return blocks && blocks->nodes.size() > 1; }

    // The surface in clusters, tagged (solid_maker.h), so that a blow costs what it breaks; only of large, breakable
    // solids of one surface.
    fracture::ClusterMesh clusters{};
    uint32_t cut_limit = 0;          // above all numbers of cuts
    fracture::MassProperties mass{}; // at density 1
    BodyMass body{};                 // kg
    std::vector<BodyPart> parts{};   // collision hulls, relative to the centre of mass
    float radius = 0.0f;             // m, around the centre of mass
    double bearable = 0.0;           // N, see bearable_force()
    bool anchored = false;
    bool breakable = false;                     // large enough for a cut
    std::shared_ptr<const HeldBlocks> blocks{}; // for loads; null unless the piece is anchored and breakable

  private:
    struct Arrays {
        std::once_flag made;
        SolidSurface surface;
    };
    std::shared_ptr<Arrays> arrays_ = std::make_shared<Arrays>(); // copies of a solid share them
};

using SolidPtr = std::shared_ptr<const SolidPiece>;

// Largest force of a blow that a solid withstands as a whole, N: breaking_force() of the mean section across the
// longest side of its box, volume / side. For a cube this equals the limit of Structure's pieces; panes and needles
// bear less.
[[nodiscard]] double bearable_force(const Material& material, double volume, const fracture::Box& box);

// m^2 of cracks between the pieces of a solid: half of their new surface, since a crack has two sides. At least 0.
[[nodiscard]] double new_surface(const SolidPiece& solid, std::span<const SolidPtr> pieces);

// An unbroken object. Fails as fracture() does on a mesh that cannot be broken, and with invalid_setting on an invalid
// material or minimum size.
[[nodiscard]] fracture::Result<SolidPtr> make_solid(const fracture::TriangleMesh& mesh,
                                                    const SolidSettings& settings = {});

// A limit of the cracks of a cut, m^2; a crack has two sides, and counts once.
struct CrackBudget {
    double limit = 0.0;
    double surface = 0.0; // set by the cut

    [[nodiscard]] bool exceeded() const { return surface > limit; }
};

// Cuts a solid along the Voronoi cells of sites. Cells of one group stay together where they touch. The pieces are in
// the order of fracture(), and their volumes sum to the solid's. Collision parts are the hulls of cells, so parts of
// different pieces do not overlap, except those of two islands of one cell. Fails as fracture() does, with
// Status::cancelled once `cancelled` returns true. A budget that the cracks exceed ends the work before hulls are made;
// the result is empty then.
[[nodiscard]] fracture::Result<std::vector<SolidPtr>>
break_solid(const SolidPiece& solid, std::span<const glm::dvec3> sites, std::span<const uint32_t> groups,
            const SolidSettings& settings, const std::function<bool()>& cancelled = {}, CrackBudget* budget = nullptr);

// Cuts a solid between blocks of different islands, which islands_under_load() and islands_after_blow() number.
// Precondition: solid.blocks, and one island a block. An island below the minimum size joins the neighbour that it
// touches most. One piece where no cut remains; otherwise as break_solid().
[[nodiscard]] fracture::Result<std::vector<SolidPtr>> break_apart(const SolidPiece& solid,
                                                                  std::span<const uint32_t> islands,
                                                                  const SolidSettings& settings,
                                                                  const std::function<bool()>& cancelled = {});

// A piece of a fracture, with one collision hull. Source triangles are those of the fracture's input.
[[nodiscard]] SolidPtr solid_of(const fracture::Fragments& fragments, const fracture::Piece& piece,
                                const SolidSettings& settings);
// A solid that is fixed and never cut. Its collision hulls follow its surface (surface_parts.h), so the mesh may be
// concave, open or pass through itself. Fails with invalid_mesh where no triangle has an area.
[[nodiscard]] fracture::Result<SolidPtr> fixed_solid(const fracture::TriangleMesh& mesh);
// All pieces of a fracture, made in parallel on `threads` threads (0: one a core). `hollow` gives each piece as many
// collision hulls as its shape takes, as make_solid() does. Fails with invalid_setting as make_solid() does.
[[nodiscard]] fracture::Result<std::vector<SolidPtr>>
solids_of(const fracture::Fragments& fragments, const SolidSettings& settings, bool hollow, uint32_t threads = 0);

} // namespace brittle::physics
