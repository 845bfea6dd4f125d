// Draws the pieces, the ground and the background, in this order, so that the depth test skips hidden pixels. It is one
// pass, so that a tile-based GPU keeps its tiles.
#pragma once

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"

namespace brittle::engine {

class ShadePass {
  public:
    ShadePass(const Device& device, VkPipelineLayout layout, const TargetFormat& target, const Quality& quality);
    void declare(Frame& frame) const; // replaces the contents of frame.colour and frame.depth

  private:
    Pipeline pieces_, fading_pieces_;
    Pipeline smooth_pieces_, fading_smooth_pieces_;
    Pipeline edges_; // null without Device::has_line_mode()
    Pipeline ground_;
    Pipeline background_;
};

} // namespace brittle::engine
