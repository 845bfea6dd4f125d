// Draws the handle of the piece that each pixel shows, for picking and for exact tests.
#pragma once

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"
#include "engine/render/material_input.h"

namespace brittle::engine {

class IdPass {
  public:
    IdPass(const Device& device, VkPipelineLayout layout);

    // Declares the pass and returns its image: Format::r32_uint, one sample, PieceHandle::number or 0 in each pixel.
    [[nodiscard]] Image declare(Frame& frame, VkExtent2D extent);

  private:
    void make_material_pipelines();

    const Device& device_;
    VkPipelineLayout layout_;
    Pipeline pipeline_;
    Pipeline fading_;
    MaterialPipelines materials_; // of materials that are cut out; `solid` is null
};

} // namespace brittle::engine
