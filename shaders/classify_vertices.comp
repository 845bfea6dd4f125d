// Finds the nearest site of each vertex by rings of bins around the vertex's bin, until no remaining site can be as
// near. A vertex is marked uncertain when the distances to the nearest and the second nearest site differ by no more
// than rounding.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "classify.h"

layout(local_size_x = classify_group_size) in;
layout(push_constant) uniform Push { ClassifyGrid grid; };
layout(std430, binding = classify_binding_positions) readonly buffer Positions { float positions[]; };
layout(std430, binding = classify_binding_sites) readonly buffer Sites { vec4 sites[]; };
layout(std430, binding = classify_binding_bins) readonly buffer Bins { uint bin_begin[]; };
layout(std430, binding = classify_binding_vertex_answers) writeonly buffer Answers { uint answers[]; };

float nearest, second;
uint nearest_site;

float squared_distance_error(float d2);

void visit_site(uint site, float d2) {
    if (d2 < nearest) {
        second = nearest;
        nearest = d2;
        nearest_site = site;
    } else {
        second = min(second, d2);
    }
}

bool can_stop(float gap2) {
    return gap2 > nearest + squared_distance_error(nearest);
}

#include "classify_rings.glsl"

void main() {
    const uint v = gl_GlobalInvocationID.x;
    if (v >= grid.bins.w) return;
    nearest = uintBitsToFloat(0x7f800000u);
    second = nearest;
    nearest_site = 0;
    visit_sites(vec3(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]));
    // Without a second nearest site, every other site was skipped as farther, or its squared distance overflows.
    const float error = squared_distance_error(nearest) + squared_distance_error(second);
    const bool certain = isinf(second) ? nearest < 1e37 : second - nearest > error;
    answers[v] = nearest_site | (certain ? 0 : classify_uncertain);
}
