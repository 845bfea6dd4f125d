// Enlarges a picture that was drawn with fewer pixels than its target has: each pixel the mean of the four
// nearest, weighted by distance. Bilinear, because a CPU device does it in a fraction of the time that
// drawing saves; a sharper filter would read 16.
#pragma once

#include "engine/render/frame.h"

namespace brittle::engine {

// Pixels around a region that must be drawn, so that it can be enlarged: one that is read, and one to spare.
inline constexpr int32_t upscale_margin = 2;

// frame.colour, which is finished, into frame.picture: at least the scene's region.
void declare_upscale(Frame& frame);

} // namespace brittle::engine
