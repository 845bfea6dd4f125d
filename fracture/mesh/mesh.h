// An indexed triangle mesh: the input of a fracture.
//
// Conventions of the whole library: right-handed coordinates, Y up, metres; triangles counter-clockwise seen from
// outside; double precision. A mesh is plain data. The functions over it are free functions in the headers named for
// their results (topology.h, mass_properties.h, io/).
//
//     const TriangleMesh tetrahedron{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
//                                    {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/box.h"

namespace brittle::fracture {

using Triangle = glm::uvec3; // three indices into TriangleMesh::positions

// The null index of vertices, triangles and half-edges.
inline constexpr uint32_t no_index = 0xffffffffu;

struct TriangleMesh {
    std::vector<glm::dvec3> positions;
    std::vector<Triangle> triangles;
};

// Returns the smallest axis-aligned box around all positions, used or unused; the zero box if there are none.
[[nodiscard]] Box bounds(std::span<const glm::dvec3> positions);
[[nodiscard]] inline Box bounds(const TriangleMesh& mesh) {
    return bounds(mesh.positions);
}

} // namespace brittle::fracture
