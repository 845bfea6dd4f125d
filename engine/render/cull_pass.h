// Leaves out of the indirect commands the pieces that neither the camera nor, for the shadow map, the light
// can see: a sphere around each piece against the six planes of a view.
#pragma once

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"

namespace brittle::engine {

class CullPass {
  public:
    CullPass(const Device& device, VkPipelineLayout layout);

    // Makes frame.camera_commands and, for a frame that draws the shadow map, frame.light_commands.
    void declare(Frame& frame, bool for_shadow) const;

  private:
    Pipeline pipeline_;
};

} // namespace brittle::engine
