// What a view shows: both C++ and GLSL compile this file, so that nothing is called unseen that is drawn.
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

// Whether a ball that is moved along a segment stays on the outer side of a plane, whose normal points inwards and need
// not be a unit vector.
BRITTLE_SHARED_FUNCTION bool outside_plane(vec4 plane, vec3 from, vec3 to, float radius) {
    return max(dot(vec3(plane), from), dot(vec3(plane), to)) + plane.w < -radius * length(vec3(plane));
}

// Whether the ball, on its way, reaches into the clip volume (Vulkan's: depth from 0). What is beyond a corner may be
// called seen; a ball with a coordinate that is no number is.
BRITTLE_SHARED_FUNCTION bool intersects_frustum(mat4 clip, vec3 from, vec3 to, float radius) {
    mat4 row = transpose(clip);
    float reach = 1.001f * radius + 1e-5f * max(length(from), length(to)); // some more, for rounding
    return !(outside_plane(row[3] + row[0], from, to, reach) || outside_plane(row[3] - row[0], from, to, reach)
             || outside_plane(row[3] + row[1], from, to, reach) || outside_plane(row[3] - row[1], from, to, reach)
             || outside_plane(row[2], from, to, reach) || outside_plane(row[3] - row[2], from, to, reach));
}

#undef BRITTLE_SHARED_FUNCTION
#ifdef __cplusplus
} // namespace brittle::engine::shared
#endif

#endif
