// The exact fracture: a restricted Voronoi diagram of the mesh's surface with capped facets.
//
// From the sites' cells (diagram.h) and the cell of each mesh vertex (classify.h), mesh edges and triangles
// are cut where they cross (edges.h, clip.h), Voronoi vertices learn whether they lie in the solid
// (winding.h), each facet's inside is triangulated once for both sides (caps.h), and the parts are put
// together (assemble.h), split into islands (islands.h) and bonded (bonds.h). Every decision is an exact
// predicate (predicates.h), what degenerate input leaves is taken back (slivers.h), and every vertex of the result has one identity and one position, so pieces are
// closed by construction, whatever the geometry.
//
// The triangles must pair up along their edges (surface.h); the surface may overlap itself, in which case
// pieces are closed too and their signed volumes sum to the mesh's. Cost grows with vertices, cut triangles
// and cells.
#pragma once

#include <memory>
#include <span>

#include "fracture/base/error.h"
#include "fracture/exact/classify.h"
#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "fracture/settings.h"

namespace brittle::fracture::exact {

// Memory of a fracture, kept for the next one: from the second fracture of similar size on hardly anything is
// allocated. Use one for each thread that fractures.
class Workspace {
  public:
    Workspace();
    ~Workspace();
    Workspace(Workspace&&) noexcept;
    Workspace& operator=(Workspace&&) noexcept;

    struct State;
    [[nodiscard]] State& state() { return *state_; }
    [[nodiscard]] const State& state() const { return *state_; }

  private:
    std::unique_ptr<State> state_;
};

// How the last fracture of a workspace was decided.
struct Statistics {
    PredicateStats predicates;
    uint64_t forced_ears = 0;  // cap triangles that no strict ear allowed (degenerate input)
    uint64_t slivers = 0;      // triangles without area that the cut left (slivers.h), a cap's counted once,
    uint64_t slivers_left = 0; // and those of them that could not be taken back
};
[[nodiscard]] Statistics statistics(const Workspace& workspace);

// Fractures into `out`, reusing its memory. settings.algorithm is not looked at.
// Errors: as fracture() (fracture.h); out is then unspecified.
[[nodiscard]] Result<void> fracture_exact(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                          const Settings& settings, Workspace& workspace, Fragments& out);

[[nodiscard]] Result<Fragments> fracture_exact(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                               const Settings& settings = {});

} // namespace brittle::fracture::exact
