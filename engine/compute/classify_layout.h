// The descriptors of the classification passes.
#pragma once

#include <cstdint>

#include <vulkan/vulkan.h>

namespace brittle::engine {

class Device;
class DeviceBuffer;

// The pipeline layout of all classification passes: one descriptor set of storage buffers, with the bindings of
// shaders/classify.h, and the grid in push constants.
class ClassifyLayout {
  public:
    explicit ClassifyLayout(const Device& device); // throws VulkanFailure
    ~ClassifyLayout();
    ClassifyLayout(const ClassifyLayout&) = delete;
    ClassifyLayout& operator=(const ClassifyLayout&) = delete;

    [[nodiscard]] VkPipelineLayout handle() const { return layout_; }
    [[nodiscard]] VkDescriptorSet set() const { return set_; }

    // Binds a buffer. No pending submission may use the set.
    void write(uint32_t binding, const DeviceBuffer& buffer) const;

  private:
    void create();
    void destroy();

    VkDevice device_;
    VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
};

} // namespace brittle::engine
