// Enlarges a picture that was drawn with fewer pixels than its target has: each pixel the mean of the four
// nearest, weighted by distance. Bilinear, because a CPU device does it in a fraction of the time that
// drawing saves; a sharper filter would read 16.
#pragma once

#include "engine/render/frame.h"

namespace brittle::engine {

// frame.colour, which is finished, into the whole of frame.picture.
void declare_enlarge(Frame& frame);

} // namespace brittle::engine
