// The parts of a mesh that unite() unites by halves: connected components, each with the cavities in it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

struct MeshPart {
    std::vector<uint32_t> triangles{}; // in ascending order
    Box box;
};

// Returns the parts in the order of their first triangles; a component with negative volume belongs to the smallest part
// around it. Nothing where one has no part around it: it counts against all parts that it meets, so they can't be united
// by themselves.
[[nodiscard]] std::optional<std::vector<MeshPart>> parts_of(const TriangleMesh& mesh);

[[nodiscard]] Box both(const Box& a, const Box& b);
[[nodiscard]] int longest_axis(const Box& box);

// Returns whether a part meets more than `most` others on average, by their boxes.
[[nodiscard]] bool is_crowded(const std::vector<MeshPart>& parts, double most);

} // namespace brittle::fracture
