// Graphics pipelines for dynamic rendering, and compute pipelines.
//
//     Pipeline pipeline(device, {.name = "lines", .layout = layout, .vertex = line_vert, .fragment = line_frag,
//                                .colour = VK_FORMAT_R8G8B8A8_UNORM, ...});
//
// The common state of all graphics pipelines is fixed: counter-clockwise front faces, depth in D32,
// dynamic viewport and scissor.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include <vulkan/vulkan.h>

namespace brittle::engine {

class Device;

// What becomes of the colour of the attachment under a fragment.
enum class Blend {
    replace, // by the fragment's
    add,     // the sum of both
    over,    // mixed with the fragment's by its alpha; the alpha of the attachment stays
};

struct PipelineDesc {
    const char* name = "";
    VkPipelineLayout layout = VK_NULL_HANDLE;
    std::span<const uint32_t> vertex{};   // SPIR-V
    std::span<const uint32_t> fragment{}; // SPIR-V; empty: depth only
    std::span<const VkVertexInputBindingDescription> bindings{};
    std::span<const VkVertexInputAttributeDescription> attributes{};
    VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkPolygonMode fill = VK_POLYGON_MODE_FILL;
    VkCullModeFlags cull = VK_CULL_MODE_BACK_BIT;
    bool depth = true; // whether there is a depth attachment
    bool depth_write = true;
    VkCompareOp depth_test = VK_COMPARE_OP_LESS_OR_EQUAL;
    VkFormat colour = VK_FORMAT_UNDEFINED; // undefined: no colour attachment
    Blend blend = Blend::replace;
    uint32_t samples = 1;                            // samples a pixel, in every attachment
    const VkSpecializationInfo* constants = nullptr; // for the fragment shader
};

class Pipeline {
  public:
    Pipeline() = default;
    // The constructors throw VulkanFailure.
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

// The attachments of a dynamic rendering. A null view means no attachment. With a resolve view, the colour view is
// multisampled and its samples are discarded at the end.
struct Rendering {
    VkExtent2D extent{};
    VkImageView colour = VK_NULL_HANDLE;
    VkAttachmentLoadOp colour_load = VK_ATTACHMENT_LOAD_OP_LOAD; // the clear value is 0
    VkImageView resolve = VK_NULL_HANDLE; // a single-sampled image that receives the mean of each pixel's samples
    VkImageView depth = VK_NULL_HANDLE;
    VkAttachmentLoadOp depth_load = VK_ATTACHMENT_LOAD_OP_LOAD; // the clear value is 1, the far plane
    VkAttachmentStoreOp depth_store = VK_ATTACHMENT_STORE_OP_STORE;
    std::optional<VkRect2D> scissor{}; // within the extent; unset: the whole extent
};
// Begins dynamic rendering over the whole extent, and sets the viewport to the extent and the scissor.
void begin_rendering(VkCommandBuffer commands, const Rendering& rendering);

} // namespace brittle::engine
