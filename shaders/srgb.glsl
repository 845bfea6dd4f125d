// The sRGB curve (IEC 61966-2-1) and its inverse.
#ifndef BRITTLE_SRGB_GLSL
#define BRITTLE_SRGB_GLSL

vec3 linear_of(vec3 srgb) {
    return mix(pow((srgb + 0.055) / 1.055, vec3(2.4)), srgb / 12.92, lessThanEqual(srgb, vec3(0.04045)));
}

vec3 srgb_of(vec3 c) {
    vec3 low = 12.92 * c;
    vec3 high = 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055;
    return mix(high, low, lessThanEqual(c, vec3(0.0031308)));
}

#endif
