// Checks that the triangles of the mesh pair up along their edges, and finds the connected components.
//
// Nearly every mesh is sound, so a parallel check without false positives (manifold_check.h) comes first;
// check_topology() counts the faults only where it fails. A surface is often cut more than once (another pattern,
// another seed, the next impact), so the triangles are kept: comparing them takes a tenth of the time of a check.
#pragma once

#include <vector>

#include "fracture/base/error.h"
#include "fracture/base/threads.h"
#include "fracture/exact/scene.h"
#include "fracture/mesh/manifold_check.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture::exact {

class Surface {
  public:
    // Checks the mesh. Errors, each with counts and the first offender:
    //  - invalid_mesh: an index out of range, a triangle that names a vertex twice;
    //  - not_closed, non_manifold, not_oriented: edges that do not pair up;
    //  - non_manifold: all edges pair up, but separate parts of the surface touch in a vertex (split_fans() helps).
    // The enclosed volume is not examined: a surface that is inside out or flat passes.
    [[nodiscard]] Result<void> inspect(const TriangleMesh& mesh, Threads& threads);

    // The connected component of each vertex, identified by its lowest vertex. no_index for a vertex without triangles,
    // and for one of two triangles back to back: a component that encloses nothing and is left out of the cut.
    [[nodiscard]] const std::vector<uint32_t>& components() const { return component_; }
    [[nodiscard]] uint32_t component_count() const { return component_count_; }
    [[nodiscard]] bool leaves_triangles_out() const { return leaves_triangles_out_; }

  private:
    [[nodiscard]] bool is_known(const TriangleMesh& mesh, Threads& threads) const;
    void find_components(const TriangleMesh& mesh, Threads& threads);

    ManifoldCheck check_;
    std::vector<Triangle> known_; // the last mesh that passed
    bool is_complete_ = false;    // whether known_ and component_ are: neither an error nor a cancellation left them
    std::vector<uint32_t> component_;
    uint32_t component_count_ = 0;
    bool leaves_triangles_out_ = false;
};

} // namespace brittle::fracture::exact
