// The mesh of a splinter: two crooked pyramids with a common base, counter-clockwise seen from outside.
#ifndef BRITTLE_SPLINTER_GLSL
#define BRITTLE_SPLINTER_GLSL

#include "frame.glsl"

layout(location = 0) in vec4 rotation;
layout(location = 1) in vec4 centre_and_length;
layout(location = 2) in vec4 colour_and_width;

const vec3 splinter_tips[2] = vec3[](vec3(1.0, 0.15, -0.1), vec3(-1.0, -0.1, 0.2));
const vec3 splinter_base[4] =
    vec3[](vec3(0.2, 1.0, 0.1), vec3(-0.1, 0.15, 0.7), vec3(0.05, -0.9, -0.1), vec3(-0.15, 0.1, -0.6));

// Returns a vertex in world space, relative to `origin`.
vec3 splinter_vertex(int vertex, vec3 origin) {
    int face = vertex / 3, corner = vertex % 3, side = face / 4, edge = face % 4;
    vec3 at = corner == 0 ? splinter_tips[side] : splinter_base[(edge + (corner == 1 ? side : 1 - side)) % 4];
    float width = centre_and_length.w * colour_and_width.w;
    at *= vec3(centre_and_length.w, width, width);
    return rotate(rotation, at) + (centre_and_length.xyz - origin);
}

#endif
