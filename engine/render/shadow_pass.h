// Draws the depth of all pieces, seen from the sun, into the shadow map; of spheres where they cast shadows.
#pragma once

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"
#include "engine/render/sphere_mesh.h"

namespace brittle::engine {

class ShadowPass {
  public:
    ShadowPass(const Device& device, VkPipelineLayout layout, const SphereMesh& sphere); // which outlives it
    void declare(Frame& frame) const; // replaces frame.shadow's content

  private:
    Pipeline pipeline_;
    Pipeline fading_;
    Pipeline spheres_;
    const SphereMesh& sphere_;
};

} // namespace brittle::engine
