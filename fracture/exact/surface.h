// Whether the mesh's triangles pair up, and which of its vertices are connected.
//
// Nearly every mesh is sound, so that is what is made quick: a parallel check that cannot miss
// (manifold_check.h). Only where it fails, check_topology() counts what is wrong. A surface is often cut more
// than once (another pattern, another seed, the next impact): the triangles are kept, and found equal in a
// tenth of the time.
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
    // Errors, each with counts and the first offender:
    //  - invalid_mesh: an index out of range, a triangle that names a vertex twice;
    //  - not_closed, non_manifold, not_oriented: edges that do not pair up;
    //  - non_manifold: all edges pair up, but separate parts of the surface touch in a vertex
    //    (split_fans() helps).
    // What it encloses, and how much, is not asked: inside out or flat is sound.
    [[nodiscard]] Result<void> inspect(const TriangleMesh& mesh, Threads& threads);

    // The connected component of each vertex, named by its least vertex; no_index for a vertex that no triangle
    // uses, or only two triangles back to back: a component that encloses nothing, and is left out of the
    // cut.
    [[nodiscard]] const std::vector<uint32_t>& components() const { return component_; }
    [[nodiscard]] uint32_t component_count() const { return component_count_; }
    [[nodiscard]] bool leaves_triangles_out() const { return leaves_triangles_out_; }

  private:
    [[nodiscard]] bool is_known(const TriangleMesh& mesh, Threads& threads) const;
    void find_components(const TriangleMesh& mesh, Threads& threads);

    ManifoldCheck check_;
    std::vector<Triangle> known_; // sound
    std::vector<uint32_t> component_;
    uint32_t component_count_ = 0;
    bool leaves_triangles_out_ = false;
};

} // namespace brittle::fracture::exact
