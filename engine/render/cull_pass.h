// Frustum culling of pieces on the device: tests the bounding sphere of each piece against the six planes of the
// camera's view and, for the shadow map, of the light's, and writes the indirect draw commands of each view.
#pragma once

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"

namespace brittle::engine {

class CullPass {
  public:
    CullPass(const Device& device, VkPipelineLayout layout);

    // Makes frame.camera_commands and, with `for_shadow`, frame.light_commands. The frame must draw pieces.
    void declare(Frame& frame, bool for_shadow) const;

  private:
    Pipeline pipeline_;
};

} // namespace brittle::engine
