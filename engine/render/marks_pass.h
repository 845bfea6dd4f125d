// Draws the marks of a scene over the shaded picture: spheres (Voronoi sites) and debug lines.
#pragma once

#include <cstdint>

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"
#include "engine/render/sphere_mesh.h"

namespace brittle::engine {

class MarksPass {
  public:
    // The minimum size of the sphere buffer, bytes. Validation layer 1.3.239 assumes one instance for each vertex of
    // the sphere mesh; with a smaller buffer it reports a hazard with memory behind the buffer.
    static constexpr uint64_t min_spheres_size = 8 * 16 * 3 * sizeof(Sphere);

    // `sphere` must outlive the pass.
    MarksPass(const Device& device, VkPipelineLayout layout, const TargetFormat& target, const SphereMesh& sphere);

    // Declares up to two passes over frame.colour: marks that pieces may hide, then marks on top of the pieces. Those on
    // top have a depth image of their own, because later passes read frame.depth.
    void declare(Frame& frame, VkExtent2D extent) const;

  private:
    struct Marks {
        bool lines;
        bool spheres;
    };
    // Returns the new version of `depth`.
    Image declare(Frame& frame, const char* name, Marks marks, Image depth, VkAttachmentLoadOp depth_load,
                  bool last) const;

    Pipeline spheres_;
    Pipeline lines_;
    const SphereMesh& sphere_;
    uint32_t samples_;
};

} // namespace brittle::engine
