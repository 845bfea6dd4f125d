// What the mesh's triangles alone say: whether they bound a solid, and which vertices are connected.
//
// A surface is often cut more than once (another pattern, another seed, the next impact), so the answer is
// kept with a 64-bit hash of the triangles and found again in a tenth of the time.
#pragma once

#include <vector>

#include "fracture/error.h"
#include "fracture/parallel.h"
#include "fracture/exact/scene.h"
#include "fracture/mesh.h"

namespace brittle::fracture::exact {

class Surface {
  public:
    // Errors: invalid_mesh, with counts and the first offender, where an index is out of range, a triangle
    // names a vertex twice, or the directed edges do not cancel out. The last is a sum of hashes: it cannot
    // see an edge that is used by two triangles in each direction; the cut finds those where it meets them.
    [[nodiscard]] Result<void> inspect(const TriangleMesh& mesh);

    // The connected component of each vertex, named by its least vertex; kNone for a vertex that no triangle
    // uses.
    [[nodiscard]] const std::vector<uint32_t>& components() const { return component_; }
    [[nodiscard]] uint32_t component_count() const { return component_count_; }
    [[nodiscard]] bool leaves_triangles_out() const { return leaves_triangles_out_; }

  private:
    void find_components(const TriangleMesh& mesh);

    uint64_t hash_ = 0;
    bool known_ = false;
    std::vector<uint32_t> component_;
    uint32_t component_count_ = 0;
    bool leaves_triangles_out_ = false;
};

} // namespace brittle::fracture::exact
