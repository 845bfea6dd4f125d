// Counts where a fill passes through the surface that it closes.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "fracture/mesh/mesh.h"
#include "fracture/mesh/triangle_tree.h"

namespace brittle::fracture::mending {

class Crossings {
  public:
    // The triangles of the mesh at this time. Positions may be appended later.
    explicit Crossings(const TriangleMesh& mesh);

    // Returns the number of pairs of a fill's triangle and another one, of the mesh or of the fill, that intersect
    // (intersections.h).
    // Nothing once all calls together have compared twenty million pairs, as in a soup of triangles.
    [[nodiscard]] std::optional<uint64_t> count(std::span<const Triangle> fill);

  private:
    [[nodiscard]] uint64_t count_below(uint32_t node, const Triangle& t, const Box& box);
    [[nodiscard]] uint64_t compare(const Triangle& s, const Triangle& t);

    const TriangleMesh& mesh_;
    TriangleTree tree_;
    uint64_t pairs_ = 0; // compared so far
};

} // namespace brittle::fracture::mending
