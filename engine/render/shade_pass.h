// Draws everything that light falls on: the pieces, then the ground, then the background. In that order, so
// that the depth test spares the pixels that end up hidden; one pass, so that a tile-based GPU keeps its
// tiles.
#pragma once

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"

namespace brittle::engine {

class ShadePass {
  public:
    ShadePass(const Device& device, VkPipelineLayout layout, const TargetFormat& target, const Quality& quality);
    void declare(Frame& frame) const; // replaces frame.colour's and frame.depth's contents

  private:
    Pipeline pieces_, fading_pieces_;
    Pipeline smooth_pieces_, fading_smooth_pieces_;
    Pipeline edges_; // none where the device cannot draw triangles as lines
    Pipeline ground_;
    Pipeline background_;
};

} // namespace brittle::engine
