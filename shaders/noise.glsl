// Hashes and value noise of the points of a lattice.
#ifndef BRITTLE_NOISE_GLSL
#define BRITTLE_NOISE_GLSL

// Three hashes of a lattice point (Jarzynski and Olano 2020, pcg3d).
uvec3 hashes(ivec3 lattice) {
    uvec3 v = uvec3(lattice) * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

float unit(uint hash) {
    return float(hash >> 8u) * (1.0 / 16777216.0);
}

// Value noise from 0 to 1 on a lattice of side 1.
float noise(vec3 p) {
    vec3 low = floor(p), t = p - low;
    ivec3 i = ivec3(low);
    t = t * t * (3.0 - 2.0 * t);
    vec4 near, far;
    near.x = unit(hashes(i).x);
    near.y = unit(hashes(i + ivec3(1, 0, 0)).x);
    near.z = unit(hashes(i + ivec3(0, 1, 0)).x);
    near.w = unit(hashes(i + ivec3(1, 1, 0)).x);
    far.x = unit(hashes(i + ivec3(0, 0, 1)).x);
    far.y = unit(hashes(i + ivec3(1, 0, 1)).x);
    far.z = unit(hashes(i + ivec3(0, 1, 1)).x);
    far.w = unit(hashes(i + ivec3(1, 1, 1)).x);
    vec4 layer = mix(near, far, t.z);
    vec2 row = mix(layer.xy, layer.zw, t.y);
    return mix(row.x, row.y, t.x);
}

#endif
