// Draws the shadow map: the depth, seen from the sun, of all pieces and splinters and, with
// Scene::spheres_cast_shadows, of all spheres.
#pragma once

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"
#include "engine/render/material_input.h"
#include "engine/render/sphere_mesh.h"

namespace brittle::engine {

class ShadowPass {
  public:
    // `sphere` must outlive the pass.
    ShadowPass(const Device& device, VkPipelineLayout layout, const SphereMesh& sphere);
    void declare(Frame& frame); // replaces the contents of frame.shadow

  private:
    void make_material_pipelines();

    const Device& device_;
    VkPipelineLayout layout_;
    Pipeline pipeline_;
    Pipeline fading_;
    MaterialPipelines materials_; // of materials that are cut out; `solid` is null
    Pipeline glass_;
    Pipeline spheres_;
    Pipeline splinters_;
    const SphereMesh& sphere_;
};

} // namespace brittle::engine
