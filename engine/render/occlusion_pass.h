// Ambient occlusion: how much of the sky each pixel's surface sees past what is near it. That darkens the
// ground under what stands on it, and the gaps between pieces.
//
// Two passes before shading: depth alone, with one sample a pixel, then a search in it around each pixel.
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
