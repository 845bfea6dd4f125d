// Screen-space ambient occlusion: the share of the sky that is visible from each pixel's surface. It darkens gaps
// between pieces, and the ground under them.
//
// Two passes run before shading: depth, with one sample a pixel, and the search in the depth image around each pixel.
#pragma once

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"

namespace brittle::engine {

class OcclusionPass {
  public:
    OcclusionPass(const Device& device, VkPipelineLayout layout);
    void declare(Frame& frame, VkExtent2D extent) const; // makes frame.occlusion

  private:
    Pipeline pieces_;
    Pipeline fading_;
    Pipeline ground_;
    Pipeline occlusion_;
};

} // namespace brittle::engine
