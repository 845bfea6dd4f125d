// Graphics pipelines for dynamic rendering, and compute pipelines.
//
//     Pipeline pipeline(device, {.name = "lines", .layout = layout, .vertex = line_vert, .fragment =
//     line_frag,
//                                .colour = VK_FORMAT_R8G8B8A8_UNORM, ...});
//
// What all of Brittle's graphics pipelines have in common is fixed: no blending, counter-clockwise front faces, depth in
// D32, dynamic viewport and scissor.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include <vulkan/vulkan.h>

namespace brittle::engine {

class Device;

struct PipelineDesc {
    const char* name = "";
    VkPipelineLayout layout = VK_NULL_HANDLE;
    std::span<const uint32_t> vertex{};   // SPIR-V
    std::span<const uint32_t> fragment{}; // empty: depth only
    std::span<const VkVertexInputBindingDescription> bindings{};
    std::span<const VkVertexInputAttributeDescription> attributes{};
    VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkPolygonMode fill = VK_POLYGON_MODE_FILL;
    VkCullModeFlags cull = VK_CULL_MODE_BACK_BIT;
    bool depth = true; // there is a depth attachment
    bool depth_write = true;
    VkCompareOp depth_test = VK_COMPARE_OP_LESS_OR_EQUAL;
    VkFormat colour = VK_FORMAT_UNDEFINED;           // undefined: no colour attachment
    uint32_t samples = 1;                            // of every attachment
    const VkSpecializationInfo* constants = nullptr; // of the fragment shader
};

class Pipeline {
  public:
    Pipeline() = default;
    // Throw VulkanFailure.
    Pipeline(const Device& device, const PipelineDesc& desc);
    Pipeline(const Device& device, const char* name, VkPipelineLayout layout, std::span<const uint32_t> compute);
    ~Pipeline();
    Pipeline(Pipeline&& other) noexcept { swap(other); }
    Pipeline& operator=(Pipeline&& other) noexcept {
        Pipeline(std::move(other)).swap(*this);
        return *this;
    }
    [[nodiscard]] VkPipeline handle() const { return pipeline_; }

  private:
    void swap(Pipeline& other) noexcept {
        std::swap(device_, other.device_);
        std::swap(pipeline_, other.pipeline_);
    }
    VkDevice device_ = VK_NULL_HANDLE;
    VkPipeline pipeline_ = VK_NULL_HANDLE;
};

// Begins dynamic rendering over the whole extent, with viewport and scissor set to it, or the scissor to a part. A null
// view is no attachment. With a view to resolve to, the colour view is multisampled and its samples are not kept.
struct Rendering {
    VkExtent2D extent{};
    VkImageView colour = VK_NULL_HANDLE;
    VkAttachmentLoadOp colour_load = VK_ATTACHMENT_LOAD_OP_LOAD; // clears to 0
    VkImageView resolve = VK_NULL_HANDLE; // of one sample: gets the means of the samples at the end
    VkImageView depth = VK_NULL_HANDLE;
    VkAttachmentLoadOp depth_load = VK_ATTACHMENT_LOAD_OP_LOAD; // clears to 1, the far plane
    VkAttachmentStoreOp depth_store = VK_ATTACHMENT_STORE_OP_STORE;
    std::optional<VkRect2D> scissor{}; // within the extent: nothing is drawn outside
};
void begin_rendering(VkCommandBuffer commands, const Rendering& rendering);

} // namespace brittle::engine
