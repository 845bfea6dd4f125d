// Draws the pieces of clear glass over the picture of all else (shaders/glass.glsl). A first pass adds up, for each
// pixel, the way of light through glass, its reflections and how far it is bent; a second one applies the sums. Neither
// sorts anything.
#pragma once

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"

namespace brittle::engine {

class GlassPass {
  public:
    GlassPass(const Device& device, VkPipelineLayout layout, const TargetFormat& target, const Quality& quality);
    // Reads frame.colour and frame.depth, and replaces the contents of `result`, which has this extent. Returns its new
    // version.
    [[nodiscard]] Image declare(Frame& frame, Image result, VkExtent2D extent) const;

  private:
    uint32_t samples_;
    Pipeline faces_, fading_faces_;
    Pipeline composite_;
};

// Returns the most pixels by which glass moves what is behind it, in a picture of so many rows.
[[nodiscard]] int32_t glass_margin(uint32_t height);

} // namespace brittle::engine
