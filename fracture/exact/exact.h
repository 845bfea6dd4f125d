// The exact fracture: the Voronoi diagram restricted to the solid, with capped facets.
//
// The phases: build the cells of the sites (diagram.h); find the cell of each mesh vertex (classify.h); cut mesh edges
// and triangles where they cross from cell to cell (edges.h, clip.h); compute the winding number of each Voronoi vertex
// (winding.h); triangulate the part of each facet inside the solid, once for both sides (caps.h); assemble the cells
// (assemble.h); collapse degenerate triangles (slivers.h); split cells into islands (islands.h) and bond them
// (bonds.h).
//
// Every decision is an exact predicate (predicates.h), and every vertex of the result has one identity and one
// position, so pieces are closed by construction, whatever the geometry. The triangles must pair up along their edges
// (surface.h). The surface may overlap itself: pieces are closed then too, and their signed volumes sum to that of the
// mesh. The cost grows with the number of vertices, cut triangles and cells.
#pragma once

#include <memory>
#include <span>

#include "fracture/base/error.h"
#include "fracture/exact/caps.h"
#include "fracture/exact/classify.h"
#include "fracture/exact/cut.h"
#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "fracture/settings.h"

namespace brittle::fracture::exact {

// The memory of fracture_exact() between calls: from the second fracture of similar size on, hardly anything is
// allocated, and a mesh that was cut before is not checked again. One for each thread that fractures.
class Scratch {
  public:
    Scratch();
    ~Scratch();
    Scratch(Scratch&&) noexcept;
    Scratch& operator=(Scratch&&) noexcept;

    struct State;
    [[nodiscard]] State& state() { return *state_; }
    [[nodiscard]] const State& state() const { return *state_; }

  private:
    std::unique_ptr<State> state_;
};

// Counts of the last fracture that used this memory.
struct Statistics {
    PredicateStats predicates;
    uint64_t forced_ears = 0;  // cap triangles that were cut without a strict ear (degenerate input)
    uint64_t slivers = 0;      // triangles without area after the cut (slivers.h); those of a cap count once
    uint64_t slivers_left = 0; // slivers that could not be removed
};
[[nodiscard]] Statistics statistics(const Scratch& scratch);

// The vertices of the last fracture that used this memory, and the scale of their positions.
[[nodiscard]] const Cut& cut(const Scratch& scratch);
[[nodiscard]] const Scene& scene(const Scratch& scratch);

// Fractures the mesh into `out` and reuses its memory. Ignores settings.algorithm and settings.rough. Errors: as
// fracture() (fracture.h); `out` is unspecified then.
[[nodiscard]] Result<void> fracture_exact(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                          const Settings& settings, Scratch& scratch, Fragments& out,
                                          const CapLattice& lattice = {});

[[nodiscard]] Result<Fragments> fracture_exact(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                               const Settings& settings = {});

} // namespace brittle::fracture::exact
