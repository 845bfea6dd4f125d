// The one call: a closed mesh and Voronoi sites go in, watertight pieces come out.
//
//     Result<TriangleMesh> mesh = import_mesh("bunny.obj");
//     auto sites = uniform_sites(bounds(*mesh), 100, 1);
//     Result<Fragments> fragments = fracture(*mesh, sites);
//
// Equal input gives equal output, bit for bit, on every machine and with every thread count.
#pragma once

#include <memory>
#include <span>

#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "fracture/settings.h"

namespace brittle::fracture {

// Memory of a fracture, kept for the next one: from the second fracture of similar size on hardly anything is allocated,
// and a mesh that was cut before is not checked anew. Use one for each thread that fractures.
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

// Cuts the mesh along the bisectors of the sites: one or more pieces (islands) per non-empty cell.
//
// Refused, each by a status of its own, with counts of all faults and the place of the first (check_topology() in
// topology.h gives the same as numbers):
//  - empty_mesh: no triangles.
//  - invalid_mesh: a position that is not finite or beyond 1e50, an index out of range, a triangle that names a vertex
//    twice, more than 2^28 triangles or vertices.
//  - not_closed: an edge of one triangle.
//  - non_manifold: an edge of three triangles or more, cut or not, even where its triangles could be paired.
//  - not_oriented: an edge whose two triangles face opposite ways.
//  - no_volume, inside_out: the surface encloses nothing but rounding; its volume is negative.
//  - invalid_sites: none, one that is not finite or beyond 1e50, for the exact algorithm also beyond 1e30 mesh sizes.
//  - cancelled: Settings::cancelled said so.
//  - invalid_setting: more than 1024 threads; groups or weights of which there are not as many as sites; a weight that is not finite; a minimum volume that is
//    negative or not finite; groups or a minimum volume for the sequential algorithm.
//
// Not refused:
//  - Solids that touch in a vertex are cut as if each had its own.
//  - A surface that passes through itself or another is cut as it is: space counts as often as the surface winds around
//    it. Pieces are closed and their signed volumes sum to the input's, but overlap where the input does; what is
//    inside out there gives pieces of negative volume (Certificate::smallest_piece tells).
//  - What encloses nothing is left out: two triangles back to back. Pieces whose volume is only rounding become part of
//    a neighbour, or are left out where they have none.
//  - Of duplicate sites the one with the lowest index owns the cell, the others are empty.
[[nodiscard]] Result<Fragments> fracture(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                         const Settings& settings = {});

// The same into `out`, whose memory is reused; unspecified after an error.
[[nodiscard]] Result<void> fracture(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                    const Settings& settings, Workspace& workspace, Fragments& out);

} // namespace brittle::fracture
