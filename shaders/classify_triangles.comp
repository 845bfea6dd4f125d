// Which triangles lie in one cell (cells are convex, so three corners decide), and which cross bisectors. Those go to a list,
// in any order, with a work group of the next pass for each run of them.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "classify_triangles.glsl"

void list_crossing(uint t, bool crosses) {
    if (crosses) crossing_list[atomicAdd(count, 1)] = t;
}
