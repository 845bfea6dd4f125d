// How a piece fades: by a pattern of the pixels that it leaves out, so that nothing needs to be sorted or blended.
#ifndef BRITTLE_FADE_GLSL
#define BRITTLE_FADE_GLSL

#include "shared.h"

layout(constant_id = constant_fading) const bool fading = false;

// The place of a pixel in the order in which those of an 8x8 block go, 0 to 63: Bayer's matrix, whose bits are those of
// x ^ y and y in turn, the last first.
uint bayer_rank(uvec2 pixel) {
    uint x = pixel.x ^ pixel.y, y = pixel.y, order = 0u;
    for (uint bit = 0u; bit < 3u; ++bit) order = order << 2 | (x >> bit & 1u) << 1 | (y >> bit & 1u);
    return order;
}

// Ends the fragment if it is not among those that are `left`, from 0 (none) to 1 (all): of 64, as many as are nearest.
void discard_faded(float opacity) {
    if (fading && 64.0 * opacity <= float(bayer_rank(uvec2(gl_FragCoord.xy))) + 0.5) discard;
}

#endif
