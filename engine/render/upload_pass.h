// Copies the geometry of new pieces into the arenas and, where an arena grew, the geometry of old pieces. Declare it
// before the passes that draw.
#pragma once

#include "engine/render/frame.h"

namespace brittle::engine {

// Declares the copies of frame.upload, if there are any. Makes new versions of frame.vertices, normals and indices.
void declare_upload(Frame& frame);

} // namespace brittle::engine
