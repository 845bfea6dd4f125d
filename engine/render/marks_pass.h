// Draws the marks of a scene over what was shaded: the spheres of the Voronoi sites, and the lines of the
// physics debug drawer.
#pragma once

#include <cstdint>

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"
#include "engine/render/sphere_mesh.h"

namespace brittle::engine {

class MarksPass {
  public:
    // Bytes that the buffer of spheres should have at least: validation layer 1.3.239 believes that instances
    // are read once a vertex, and would report what a pass before wrote behind a smaller buffer.
    static constexpr uint64_t min_spheres_size = 8 * 16 * 3 * sizeof(Sphere);

    // `sphere` outlives it.
    MarksPass(const Device& device, VkPipelineLayout layout, const TargetFormat& target, const SphereMesh& sphere);

    // Up to two passes: what the pieces hide, then what is on top of them. Adds to frame.colour.
    void declare(Frame& frame) const;

  private:
    struct Marks {
        bool lines;
        bool spheres;
    };
    void declare(Frame& frame, const char* name, Marks marks, VkAttachmentLoadOp depth_load, bool last) const;

    Pipeline spheres_;
    Pipeline lines_;
    const SphereMesh& sphere_;
};

} // namespace brittle::engine
