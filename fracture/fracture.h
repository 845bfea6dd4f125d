// The entry point of the library: cuts a closed triangle mesh into the watertight pieces of a Voronoi diagram.
//
//     Result<TriangleMesh> mesh = import_mesh("bunny.obj");
//     std::vector<glm::dvec3> sites = uniform_sites(bounds(*mesh), 100, 1);
//     Result<Fragments> fragments = fracture(*mesh, sites);
//
// Right-handed coordinates, Y up, metres; triangles counter-clockwise seen from outside (mesh.h). Equal input gives
// equal output, bit for bit, on every machine and for every thread count. fracture() is reentrant: concurrent calls
// need a Workspace each and share nothing else.
#pragma once

#include <memory>
#include <span>

#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "fracture/settings.h"

namespace brittle::fracture {

// Memory that fracture() reuses. From the second fracture of similar size on, hardly anything is allocated, and the
// validity check of a mesh that the workspace has already seen is skipped. Not synchronised: one workspace for each
// thread that calls fracture().
class Workspace {
  public:
    Workspace();
    ~Workspace();
    Workspace(Workspace&&) noexcept;
    Workspace& operator=(Workspace&&) noexcept;

    struct State;
    [[nodiscard]] State& state() { return *state_; }

  private:
    std::unique_ptr<State> state_;
};

// Cuts the mesh along the bisectors of the sites. Each Voronoi cell that meets the solid gives one piece per connected
// part (island).
//
// Errors. The message counts all faults of the mesh and locates the first one; check_topology() in topology.h returns
// these figures as numbers.
//  - empty_mesh: the mesh has no triangles.
//  - invalid_mesh: a coordinate is not finite or exceeds 1e50 in magnitude, an index is out of range, a triangle names
//    a vertex twice, or there are more than 2^28 triangles or vertices.
//  - not_closed: an edge belongs to one triangle only.
//  - non_manifold: an edge belongs to three triangles or more, whether or not a bisector cuts it, and even where its
//    triangles could be paired.
//  - not_oriented: the two triangles of an edge have opposite orientations.
//  - no_volume: the enclosed volume is zero up to rounding.
//  - inside_out: the enclosed volume is negative.
//  - inverted_part: a piece has negative volume, because the surface passes through itself and is inside out there.
//  - lost_volume: the volumes of the pieces miss that of the mesh by more than max_volume_error (certificate.h), because
//    parts of the mesh are as thin as the rounding of coordinates.
//  - invalid_sites: there are no sites, or a coordinate of a site is not finite or exceeds 1e50 in magnitude (for
//    Algorithm::exact also: 1e30 times the size of the mesh).
//  - invalid_setting: more than 1024 threads; a count of groups or weights that differs from the count of sites; a
//    weight that is not finite (for Algorithm::exact also: above 1e60 times the size of the mesh squared); a minimum
//    volume that is negative or not finite; groups or a minimum volume together with Algorithm::sequential.
//  - cancelled: Settings::cancelled returned true.
//
// Degenerate input that is cut:
//  - Solids that touch in a vertex: each is cut as if the vertex were its own.
//  - Self-intersecting surfaces: a region of space counts as often as the surface winds around it. Every piece is
//    closed and the volumes sum to the volume of the input, but pieces overlap where the input does. Where inside-out
//    parts prevail in a piece, its volume is negative and the mesh is refused.
//  - Components without volume, for example two triangles back to back: they give no piece.
//  - Pieces whose volume is zero up to rounding of their own coordinates (is_flat() in mesh/islands.h): they are merged
//    into a neighbour, or dropped if they have none.
//  - Duplicate sites: the cell belongs to the site with the lowest index, the cells of the others are empty.
[[nodiscard]] Result<Fragments> fracture(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                         const Settings& settings = {});

// Writes the pieces into `out` and reuses the memory of `out` and of the workspace. After an error, `out` is
// unspecified.
[[nodiscard]] Result<void> fracture(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                    const Settings& settings, Workspace& workspace, Fragments& out);

} // namespace brittle::fracture
