// Draws the pieces, the splinters, the ground and the background, in this order, so that the depth test skips hidden pixels. It is one
// pass, so that a tile-based GPU keeps its tiles.
#pragma once

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"
#include "engine/render/material_input.h"

namespace brittle::engine {

class ShadePass {
  public:
    ShadePass(const Device& device, VkPipelineLayout layout, const TargetFormat& target, const Quality& quality);
    void declare(Frame& frame); // replaces the contents of frame.colour and frame.depth

  private:
    void make_material_pipelines();
    void draw_all_pieces(Frame& frame, const PassContext& context) const;

    const Device& device_;
    VkPipelineLayout layout_;
    TargetFormat target_;
    bool soft_shadows_, ambient_occlusion_;
    Pipeline pieces_, fading_pieces_;
    Pipeline smooth_pieces_, fading_smooth_pieces_;
    MaterialPipelines materials_;
    Pipeline splinters_;
    Pipeline edges_; // null without Device::has_line_mode()
    Pipeline ground_;
    Pipeline background_;
};

} // namespace brittle::engine
