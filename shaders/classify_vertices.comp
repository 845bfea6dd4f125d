// The nearest site of each vertex, by a grid of sites: rings of bins around the vertex's own, until no site outside them
// can be as near. A vertex is marked uncertain where the second nearest is not farther by more than rounding.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "classify.h"

layout(local_size_x = classify_group_size) in;
layout(push_constant) uniform Push { ClassifyGrid grid; };
layout(std430, binding = classify_binding_positions) readonly buffer Positions { float positions[]; };
layout(std430, binding = classify_binding_sites) readonly buffer Sites { vec4 sites[]; };
layout(std430, binding = classify_binding_bins) readonly buffer Bins { uint bin_begin[]; };
layout(std430, binding = classify_binding_vertex_answers) writeonly buffer Answers { uint answers[]; };

// By how much a squared distance d2 may be off. With u = 2^-24 and no coordinate above s = radius + d, a coordinate is
// rounded by u s on either side and their difference by u d: at most 2 u s + u d a component, so 4 sqrt(3) u s d +
// 5 u d2 + 12 u^2 s^2 in the sum of squares. Twice that is allowed for.
float error_of(float d2) {
    const float d = sqrt(d2), s = grid.low.w + d;
    return 5.9604645e-8 * (16.0 * s * d + 16.0 * d2 + 1e-5 * s * s);
}

void main() {
    const uint v = gl_GlobalInvocationID.x;
    if (v >= grid.bins.w) return;
    const vec3 x = vec3(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]);
    const ivec3 bins = ivec3(grid.bins.xyz);
    const ivec3 home = clamp(ivec3((x - grid.low.xyz) / grid.bin_size.xyz), ivec3(0), bins - 1);
    const float infinity = uintBitsToFloat(0x7f800000u);
    const float slack = 9.5367432e-7 * (grid.low.w + 1.0); // of a distance to the side of a bin
    float nearest = infinity, second = infinity;
    uint site = 0;
    for (int ring = 0;; ++ring) {
        if (ring > 0) {
            // Sites that are left lie beyond the sides of the rings done, where there are bins beyond.
            float gap = infinity;
            for (int axis = 0; axis < 3; ++axis) {
                const float low = grid.low[axis] + float(home[axis] - ring + 1) * grid.bin_size[axis];
                const float high = grid.low[axis] + float(home[axis] + ring) * grid.bin_size[axis];
                if (home[axis] - ring >= 0) gap = min(gap, x[axis] - low);
                if (home[axis] + ring < bins[axis]) gap = min(gap, high - x[axis]);
            }
            if (gap == infinity) break;
            gap = max(gap - slack, 0.0);
            if (gap * gap > nearest + error_of(nearest)) break;
        }
        const ivec3 from = max(home - ring, ivec3(0)), to = min(home + ring, bins - 1);
        for (int z = from.z; z <= to.z; ++z) {
            for (int y = from.y; y <= to.y; ++y) {
                const bool inside = abs(z - home.z) < ring && abs(y - home.y) < ring;
                for (int b = from.x; b <= to.x; ++b) {
                    if (inside && abs(b - home.x) < ring) { // done before: on to the other end of the ring
                        b = min(home.x + ring, to.x + 1) - 1;
                        continue;
                    }
                    const uint bin = uint((z * bins.y + y) * bins.x + b);
                    const uint end = bin_begin[bin + 1];
                    for (uint k = bin_begin[bin]; k < end; ++k) {
                        const vec4 s = sites[k];
                        const vec3 d = x - s.xyz;
                        const float d2 = d.x * d.x + d.y * d.y + d.z * d.z;
                        if (d2 < nearest) {
                            second = nearest;
                            nearest = d2;
                            site = floatBitsToUint(s.w);
                        } else {
                            second = min(second, d2);
                        }
                    }
                }
            }
        }
    }
    // Without a second one, all others are farther, seen or not; so far that their squares overflow, some of them.
    const bool certain = isinf(second) ? nearest < 1e37 : second - nearest > error_of(nearest) + error_of(second);
    answers[v] = site | (certain ? 0 : classify_uncertain);
}
