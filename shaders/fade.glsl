// Fading by screen-door transparency: a fixed pattern of pixels is discarded, so fragments need neither sorting nor
// blending.
#ifndef BRITTLE_FADE_GLSL
#define BRITTLE_FADE_GLSL

#include "shared.h"

layout(constant_id = constant_fading) const bool fading = false;

// Returns the pixel's element, 0 to 63, of the 8x8 Bayer matrix: the bits of x ^ y and y, interleaved, with the least
// significant bits first.
uint bayer_rank(uvec2 pixel) {
    uint x = pixel.x ^ pixel.y, y = pixel.y, order = 0u;
    for (uint bit = 0u; bit < 3u; ++bit) order = order << 2 | (x >> bit & 1u) << 1 | (y >> bit & 1u);
    return order;
}

// Discards the fragment unless its pixel's Bayer element is among the first 64 * opacity, rounded; 0 discards all, 1
// none.
void discard_faded(float opacity) {
    if (fading && 64.0 * opacity <= float(bayer_rank(uvec2(gl_FragCoord.xy))) + 0.5) discard;
}

#endif
