// Separates triangles inside one cell from those that cross bisectors; cells are convex, so the corners decide. Appends
// the crossing triangles to a list, in any order, for the next pass.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "classify_triangles.glsl"

void list_crossing(uint t, bool crosses) {
    if (crosses) crossing_list[atomicAdd(count, 1)] = t;
}
