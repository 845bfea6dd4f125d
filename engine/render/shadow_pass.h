// Draws the depth of all pieces, seen from the sun, into the shadow map.
#pragma once

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"

namespace brittle::engine {

class ShadowPass {
  public:
    ShadowPass(const Device& device, VkPipelineLayout layout);
    void declare(Frame& frame) const; // replaces frame.shadow's content

  private:
    Pipeline pipeline_;
    Pipeline fading_;
};

} // namespace brittle::engine
