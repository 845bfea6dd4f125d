// Procedural colours of surfaces without a texture, by the position in the object in metres. A pattern finer than a pixel
// fades to its mean, so that it does not flicker.
#ifndef BRITTLE_GRAIN_GLSL
#define BRITTLE_GRAIN_GLSL

#include "noise.glsl"
#include "shared.h"

// Noise of a period, m, around 0, from -1 to 1. `pixel`: the size of a pixel on the surface, m.
float bumps(vec3 at, float period, float pixel) {
    float share = clamp(period / pixel - 1.0, 0.0, 1.0);
    return share > 0.0 ? share * (2.0 * noise(at / period) - 1.0) : 0.0;
}

// The sum of three octaves, about -1 to 1.
float octaves(vec3 at, float period, float pixel) {
    return 0.57 * bumps(at, period, pixel) + 0.29 * bumps(at + 17.3, 0.5 * period, pixel)
           + 0.14 * bumps(at + 41.9, 0.25 * period, pixel);
}

// The brightness of stones in cement: cells of random points of a lattice, nearest of eight. 1 between the stones.
float pebbles(vec3 at, float period, float pixel) {
    float share = clamp(0.25 * period / pixel - 0.5, 0.0, 1.0);
    if (share <= 0.0) return 1.0;
    vec3 p = at / period - 0.5;
    ivec3 low = ivec3(floor(p));
    float nearest = 8.0, bright = 1.0;
    for (int k = 0; k < 8; ++k) {
        ivec3 cell = low + ivec3(k & 1, k >> 1 & 1, k >> 2);
        uvec3 hash = hashes(cell);
        vec3 to = vec3(cell) + 0.5 * (vec3(unit(hash.x), unit(hash.y), unit(hash.z)) - 0.5) - p;
        float far = dot(to, to);
        if (far < nearest) {
            nearest = far;
            bright = 0.70 + 0.55 * unit(hash.x ^ hash.y ^ hash.z);
        }
    }
    float inside = 1.0 - smoothstep(0.36, 0.44, sqrt(nearest));
    return mix(1.0, bright, share * inside);
}

// Rings around the vertical axis of the object, with fibres along it.
vec3 wood(vec3 mean, vec3 at, float pixel) {
    const float ring = 0.028; // m
    vec3 along = at * vec3(1.0, 0.2, 1.0);
    float radius = length(at.xz + 0.35) + 0.02 * octaves(along, 0.3, pixel);
    float share = clamp(0.25 * ring / pixel - 0.5, 0.0, 1.0);
    float phase = fract(radius / ring);
    float late = smoothstep(0.45, 0.92, phase) * (1.0 - smoothstep(0.95, 1.0, phase)); // dark wood of autumn
    float fibres = bumps(at * vec3(1.0, 0.03, 1.0), 0.004, pixel);
    return mean * mix(vec3(1.12, 1.10, 1.06), vec3(0.66, 0.58, 0.50), share * late + (1.0 - share) * 0.3)
           * (1.0 + 0.10 * fibres);
}

// Returns the colour of a fracture surface.
vec3 grained(uint grain, vec3 mean, vec3 at, float pixel) {
    if (grain == grain_wood) return wood(mean, at, pixel);
    if (grain == grain_glass) return mean * (1.0 + 0.05 * bumps(at, 0.3, pixel));
    if (grain == grain_ceramic) return mean * (1.0 + 0.05 * octaves(at, 0.03, pixel));
    if (grain == grain_concrete)
        return mean * pebbles(at, 0.045, pixel)
               * (1.0 + 0.14 * octaves(at, 0.09, pixel) + 0.10 * bumps(at, 0.006, pixel));
    if (grain == grain_brick) {
        float dark = smoothstep(0.45, 0.75, bumps(at, 0.016, pixel));
        return mean * (1.0 + 0.24 * octaves(at, 0.07, pixel) + 0.12 * bumps(at + 5.0, 0.005, pixel))
               * (1.0 - 0.45 * dark);
    }
    if (grain == grain_stone) {
        float veins = octaves(at + 0.04 * octaves(at + 9.1, 0.35, pixel), 0.22, pixel);
        return mean * (1.0 + 0.30 * veins + 0.13 * bumps(at, 0.008, pixel));
    }
    return mean * (1.0 + 0.10 * octaves(at, 0.12, pixel));
}

// Returns the colour of an exterior: that of the grain, but worn, sawn, cast or fired smooth.
vec3 weathered(uint grain, vec3 mean, vec3 at, float pixel) {
    if (grain == grain_wood) return mix(mean, wood(mean, at, pixel), 0.75);
    if (grain == grain_concrete)
        return mean * (1.0 + 0.10 * octaves(at, 0.3, pixel) + 0.06 * bumps(at, 0.012, pixel))
               * (1.0 - 0.35 * smoothstep(0.62, 0.72, bumps(at + 3.7, 0.02, pixel))); // pores
    if (grain == grain_brick)
        return mean * (1.0 + 0.13 * octaves(at, 0.07, pixel) + 0.07 * bumps(at + 5.0, 0.005, pixel));
    if (grain == grain_stone) {
        float veins = octaves(at + 0.04 * octaves(at + 9.1, 0.35, pixel), 0.22, pixel);
        return mean * (1.0 + 0.14 * veins + 0.08 * bumps(at, 0.008, pixel));
    }
    return mean;
}

// The share of the reflection of a smooth coat that an exterior shows: glaze, varnish.
float gloss_of(uint grain) {
    return grain == grain_ceramic ? 1.0 : grain == grain_wood ? 0.35 : 0.0;
}

#endif
