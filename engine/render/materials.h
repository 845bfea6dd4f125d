// The materials of all meshes on the device, in descriptor set 2.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "engine/gpu/memory.h"
#include "engine/render/material_set.h"

namespace brittle::engine {

class Device;
class FrameLayout;

class Materials {
  public:
    // Uploads the sets and waits for it. The materials of the sets follow each other. Throws VulkanFailure, also with
    // invalid_argument for more layers than the device takes.
    Materials(const Device& device, const FrameLayout& layout,
              const std::vector<std::shared_ptr<const MaterialSet>>& sets);
    ~Materials();
    Materials(const Materials&) = delete;
    Materials& operator=(const Materials&) = delete;

    [[nodiscard]] VkDescriptorSet set() const { return set_; }
    [[nodiscard]] bool has_cut_outs() const { return has_cut_outs_; } // masks or blended materials
    [[nodiscard]] uint32_t cut_layer() const { return cut_layer_; }   // 1 + layer of the texture of cuts, or 0

  private:
    void create_samplers();
    void destroy();

    const Device& device_;
    DeviceBuffer materials_;
    DeviceImage base_colours_, normal_maps_;
    VkSampler sampler_ = VK_NULL_HANDLE;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
    bool has_cut_outs_ = false;
    uint32_t cut_layer_ = 0;
};

} // namespace brittle::engine
