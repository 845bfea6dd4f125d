// Copies the geometry of new pieces into the arenas, and of old ones where an arena grew. Before all that draws.
#pragma once

#include "engine/render/frame.h"

namespace brittle::engine {

// By frame.upload; nothing if that is empty. Makes new versions of the frame's vertices, normals and indices.
void declare_upload(Frame& frame);

} // namespace brittle::engine
