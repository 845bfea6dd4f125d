// The visibility test of a view. C++ and GLSL both compile this file, so that the CPU never rejects a ball that the
// cull pass draws.
#ifndef BRITTLE_SHADERS_FRUSTUM_H
#define BRITTLE_SHADERS_FRUSTUM_H

#ifdef __cplusplus
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

namespace brittle::engine::shared {
using glm::dot;
using glm::length;
using glm::mat4;
using glm::max;
using glm::transpose;
using glm::vec3;
using glm::vec4;
#define BRITTLE_SHARED_FUNCTION inline
#else
#define BRITTLE_SHARED_FUNCTION
#endif

// Returns whether a ball that moves along a segment stays outside a plane. The plane's normal points inwards and may
// have any length.
BRITTLE_SHARED_FUNCTION bool outside_plane(vec4 plane, vec3 from, vec3 to, float radius) {
    return max(dot(vec3(plane), from), dot(vec3(plane), to)) + plane.w < -radius * length(vec3(plane));
}

// Returns whether a ball that moves along a segment may intersect the clip volume (Vulkan's, with depth from 0). The
// test is conservative: it accepts balls outside an edge or corner that are outside no single plane, and balls with
// NaN.
BRITTLE_SHARED_FUNCTION bool intersects_frustum(mat4 clip, vec3 from, vec3 to, float radius) {
    mat4 row = transpose(clip);
    float reach = 1.001f * radius + 1e-5f * max(length(from), length(to)); // enlarged for rounding
    return !(outside_plane(row[3] + row[0], from, to, reach) || outside_plane(row[3] - row[0], from, to, reach)
             || outside_plane(row[3] + row[1], from, to, reach) || outside_plane(row[3] - row[1], from, to, reach)
             || outside_plane(row[2], from, to, reach) || outside_plane(row[3] - row[2], from, to, reach));
}

#undef BRITTLE_SHARED_FUNCTION
#ifdef __cplusplus
} // namespace brittle::engine::shared
#endif

#endif
