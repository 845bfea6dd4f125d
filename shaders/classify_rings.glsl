// Visits the sites around a point by rings of bins, from the nearest bins outwards: to find the nearest site, or to
// prove that no site is near. Before the #include, a shader defines visit_site() and can_stop(), and declares `grid`,
// `sites` and `bin_begin`.

// Returns a bound of the error of a computed squared distance d2. Let u = 2^-24, and let s = radius + d bound the
// coordinates of both points. Each coordinate is rounded by at most u s, and their difference by u d: at most
// 2 u s + u d in each component, hence 4 sqrt(3) u s d + 5 u d2 + 12 u^2 s^2 in the sum of squares. The bound is twice
// that.
float squared_distance_error(float d2) {
    const float d = sqrt(d2), s = grid.low.w + d;
    return 5.9604645e-8 * (16.0 * s * d + 16.0 * d2 + 1e-5 * s * s);
}

// Calls visit_site(index, squared distance) for the sites around x, until can_stop(g2) is true, where g2 is a lower
// bound of the squared distance of all remaining sites. x must be finite; it may lie outside the grid.
void visit_sites(vec3 x) {
    const ivec3 bins = ivec3(grid.bins.xyz);
    const ivec3 home = clamp(ivec3((x - grid.low.xyz) / grid.bin_size.xyz), ivec3(0), bins - 1);
    const float infinity = uintBitsToFloat(0x7f800000u);
    const float slack = 9.5367432e-7 * (grid.low.w + 1.0); // bound of the rounding error of a distance to a bin's side
    for (int ring = 0;; ++ring) {
        if (ring > 0) {
            // The remaining sites lie beyond those sides of the visited block that have bins beyond them.
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
                    if (inside && abs(b - home.x) < ring) { // visited before: skip to the other end of the ring
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
