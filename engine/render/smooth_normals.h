// Normals for smooth shading. The normal of a triangle's corner is the area-weighted mean over the triangles around the
// vertex whose normals differ from the triangle's own by at most the crease angle. A vertex at a crease therefore gets
// several normals, and is split into copies.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace brittle::engine {

struct SmoothSurface {
    std::vector<glm::uvec3> triangles; // indices of original vertices and, after them, copies
    std::vector<uint32_t> copies;      // the original vertex of each copy
    std::vector<glm::vec3> normals;    // of original vertices and copies; unit length, or 0 where undefined
};

// Returns the triangles with split vertices and their normals. Indices must be in range. Linear in the number of
// triangles: around a vertex with more than 64 triangles, each triangle keeps its own normal.
//
// The first `vertices` positions are those of the triangles. The others are those of `neighbours`, triangles beside the
// surface, which count for its normals and are not part of the result.
[[nodiscard]] SmoothSurface smooth_normals(std::span<const glm::vec3> positions, size_t vertices,
                                           std::span<const glm::uvec3> triangles,
                                           std::span<const glm::uvec3> neighbours = {});

} // namespace brittle::engine
