// Visits sites by rings of bins around a point, from the nearest bins outwards: what finds a nearest site, and what proves
// that no site is near. Who includes it defines see() and is_done() first, and declares `grid`, `sites` and `bin_begin`.

// By how much a squared distance d2 may be off. With u = 2^-24 and no coordinate above s = radius + d, a coordinate is
// rounded by u s on either side and their difference by u d: at most 2 u s + u d a component, so 4 sqrt(3) u s d +
// 5 u d2 + 12 u^2 s^2 in the sum of squares. Twice that is allowed for.
float squared_distance_error(float d2) {
    const float d = sqrt(d2), s = grid.low.w + d;
    return 5.9604645e-8 * (16.0 * s * d + 16.0 * d2 + 1e-5 * s * s);
}

// x must be finite; it may lie outside the grid.
void visit_sites(vec3 x) {
    const ivec3 bins = ivec3(grid.bins.xyz);
    const ivec3 home = clamp(ivec3((x - grid.low.xyz) / grid.bin_size.xyz), ivec3(0), bins - 1);
    const float infinity = uintBitsToFloat(0x7f800000u);
    const float slack = 9.5367432e-7 * (grid.low.w + 1.0); // of a distance to the side of a bin
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
            if (can_stop(gap * gap)) break;
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
                        visit_site(floatBitsToUint(s.w), d.x * d.x + d.y * d.y + d.z * d.z);
                    }
                }
            }
        }
    }
}
