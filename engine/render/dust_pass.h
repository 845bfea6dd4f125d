// Draws the dust of a scene over the picture of all else, from back to front (shaders/dust.glsl).
#pragma once

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"

namespace brittle::engine {

class DustPass {
  public:
    DustPass(const Device& device, VkPipelineLayout layout, const TargetFormat& target);
    // Reads frame.depth and draws into `picture`, which has one sample a pixel. Returns its new version.
    [[nodiscard]] Image declare(Frame& frame, Image picture) const;

  private:
    Pipeline puffs_;
};

} // namespace brittle::engine
