// Draws the handle of the piece that each pixel shows, for picking and for exact tests.
#pragma once

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"

namespace brittle::engine {

class IdPass {
  public:
    IdPass(const Device& device, VkPipelineLayout layout);

    // Declares the pass and returns its image: Format::r32_uint, one sample, PieceHandle::number or 0 in each pixel.
    [[nodiscard]] Image declare(Frame& frame, VkExtent2D extent) const;

  private:
    Pipeline pipeline_;
    Pipeline fading_;
};

} // namespace brittle::engine
