// The parts of a mesh that unite() unites by halves: connected components, each with the cavities in it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture::arrangement {

struct MeshPart {
    std::vector<uint32_t> triangles{}; // in ascending order
    Box box;
};

// Returns the parts where a component meets more than `most` others on average, by their boxes. A component with negative
// volume belongs to the smallest part around it; nothing is returned where there is none around one, because it counts
// against all parts that it meets.
[[nodiscard]] std::optional<std::vector<MeshPart>> crowded_parts(const TriangleMesh& mesh, double most);

// Orders the parts so that those of the first half lie lower along the longest axis of their box. Returns the size of that
// half. Precondition: there are two parts at least.
[[nodiscard]] size_t halve(std::span<MeshPart> parts);

} // namespace brittle::fracture::arrangement
