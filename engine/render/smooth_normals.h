// Normals for smooth shading: each corner of a triangle gets the mean normal of the triangles around its
// vertex that meet its own at less than an angle, weighted by area. At a crease a vertex so gets several
// normals, and is split.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace brittle::engine {

struct SmoothSurface {
    std::vector<glm::uvec3> triangles; // of the old vertices and, after them, the copies
    std::vector<uint32_t> copies;      // the old vertex that each is a copy of
    std::vector<glm::vec3> normals;    // of old vertices and copies: unit length, or 0 where a vertex has no direction
};

// Indices must be in range. Linear in the triangles: around a vertex of very many, each triangle keeps its
// own normal.
[[nodiscard]] SmoothSurface smooth_normals(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles);

} // namespace brittle::engine
