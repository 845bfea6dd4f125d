// Upscales a picture that was drawn with fewer pixels than its target has. The filter is bilinear, four texels for each
// pixel, because on a CPU device it costs a fraction of the time that the smaller picture saves; a sharper filter reads
// 16 texels.
#pragma once

#include "engine/render/frame.h"

namespace brittle::engine {

// The pixels around Scene::region that must be drawn for the upscaling: one that the filter reads, and one to spare.
inline constexpr int32_t upscale_margin = 2;

// Declares the pass from the small picture, which must be complete, to frame.picture; it covers at least Scene::region.
void declare_upscale(Frame& frame, Image small);

} // namespace brittle::engine
