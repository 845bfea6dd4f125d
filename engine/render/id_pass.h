// Draws which piece each pixel shows, as numbers: for picking, and for tests that want exact answers.
#pragma once

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"

namespace brittle::engine {

class IdPass {
  public:
    IdPass(const Device& device, VkPipelineLayout layout);

    // The image, of Format::r32_uint and one sample: a piece's handle, or 0.
    [[nodiscard]] Image declare(Frame& frame, VkExtent2D extent) const;

  private:
    Pipeline pipeline_;
    Pipeline fading_;
};

} // namespace brittle::engine
