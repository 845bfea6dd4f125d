// The mesh that goes into a fracture: an indexed triangle list.
//
// Conventions of the whole library: right-handed coordinates, Y up, metres; triangles counter-clockwise seen from
// outside; double precision. Plain data: free functions over it live in the headers named for what they compute
// (topology.h, mass_properties.h, io/).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/box.h"

namespace brittle::fracture {

using Triangle = glm::uvec3; // three indices into positions

// Stands for no vertex, triangle or half-edge.
inline constexpr uint32_t no_index = 0xffffffffu;

struct TriangleMesh {
    std::vector<glm::dvec3> positions;
    std::vector<Triangle> triangles;
};

// The smallest axis-aligned box around all positions; the zero box where there are none.
[[nodiscard]] Box bounds(std::span<const glm::dvec3> positions);
[[nodiscard]] inline Box bounds(const TriangleMesh& mesh) {
    return bounds(mesh.positions);
}

} // namespace brittle::fracture
