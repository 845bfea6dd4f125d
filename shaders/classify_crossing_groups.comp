// Computes the number of work groups for the crossing triangles: the arguments of the next dispatch.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "classify.h"

layout(local_size_x = 1) in;
layout(std430, binding = classify_binding_crossing_count) readonly buffer Count { uint count; };
layout(std430, binding = classify_binding_dispatch) writeonly buffer Dispatch { uint groups[3]; };

void main() {
    groups[0] = (count + classify_group_size - 1) / classify_group_size;
    groups[1] = 1;
    groups[2] = 1;
}
