#include "engine/gpu/pipeline.h"

#include <optional>
#include <string>
#include <vector>

#include "engine/gpu/check.h"
#include "engine/gpu/device.h"

namespace brittle::engine {

namespace {

class ShaderModule {
  public:
    ShaderModule(VkDevice device, std::span<const uint32_t> code) : device_(device) {
        const VkShaderModuleCreateInfo info{
            .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = code.size_bytes(), .pCode = code.data()};
        check(vkCreateShaderModule(device, &info, nullptr, &module_), "create a shader module");
    }
    ~ShaderModule() { vkDestroyShaderModule(device_, module_, nullptr); }
    ShaderModule(const ShaderModule&) = delete;
    ShaderModule& operator=(const ShaderModule&) = delete;
    [[nodiscard]] VkShaderModule handle() const { return module_; }

  private:
    VkDevice device_;
    VkShaderModule module_ = VK_NULL_HANDLE;
};

VkPipelineShaderStageCreateInfo stage_info(VkShaderStageFlagBits stage, const ShaderModule& module,
                                           const VkSpecializationInfo* constants) {
    return {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
            .stage = stage,
            .module = module.handle(),
            .pName = "main",
            .pSpecializationInfo = constants};
}

VkPipelineColorBlendAttachmentState blend_state(Blend blend) {
    const bool over = blend == Blend::over;
    return {.blendEnable = blend != Blend::replace,
            .srcColorBlendFactor = over ? VK_BLEND_FACTOR_SRC_ALPHA : VK_BLEND_FACTOR_ONE,
            .dstColorBlendFactor = over ? VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA : VK_BLEND_FACTOR_ONE,
            .colorBlendOp = VK_BLEND_OP_ADD,
            .srcAlphaBlendFactor = over ? VK_BLEND_FACTOR_ZERO : VK_BLEND_FACTOR_ONE,
            .dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE,
            .alphaBlendOp = VK_BLEND_OP_ADD,
            .colorWriteMask = 0xf};
}

} // namespace

Pipeline::Pipeline(const Device& device, const PipelineDesc& desc) : device_(device.handle()) {
    const ShaderModule vertex(device_, desc.vertex);
    std::vector<VkPipelineShaderStageCreateInfo> stages{stage_info(VK_SHADER_STAGE_VERTEX_BIT, vertex, nullptr)};
    std::optional<ShaderModule> fragment;
    if (!desc.fragment.empty()) {
        fragment.emplace(device_, desc.fragment);
        stages.push_back(stage_info(VK_SHADER_STAGE_FRAGMENT_BIT, *fragment, desc.constants));
    }

    const VkPipelineVertexInputStateCreateInfo input{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
        .vertexBindingDescriptionCount = static_cast<uint32_t>(desc.bindings.size()),
        .pVertexBindingDescriptions = desc.bindings.data(),
        .vertexAttributeDescriptionCount = static_cast<uint32_t>(desc.attributes.size()),
        .pVertexAttributeDescriptions = desc.attributes.data()};
    const VkPipelineInputAssemblyStateCreateInfo assembly{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO, .topology = desc.topology};
    const VkPipelineViewportStateCreateInfo viewport{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
    const VkPipelineRasterizationStateCreateInfo raster{.sType =
                                                            VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
                                                        .polygonMode = desc.fill,
                                                        .cullMode = desc.cull,
                                                        .frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE,
                                                        .lineWidth = 1.0f};
    const VkPipelineMultisampleStateCreateInfo samples{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = static_cast<VkSampleCountFlagBits>(desc.samples)};
    const VkPipelineDepthStencilStateCreateInfo depth{.sType =
                                                          VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                      .depthTestEnable = desc.depth,
                                                      .depthWriteEnable = desc.depth && desc.depth_write,
                                                      .depthCompareOp = desc.depth_test};
    const VkPipelineColorBlendAttachmentState mixing = blend_state(desc.blend);
    const bool has_colour = desc.colour != VK_FORMAT_UNDEFINED;
    const VkPipelineColorBlendStateCreateInfo blend{.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
                                                    .attachmentCount = has_colour ? 1u : 0u,
                                                    .pAttachments = &mixing};
    const VkDynamicState dynamic_states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    const VkPipelineDynamicStateCreateInfo dynamic{.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
                                                   .dynamicStateCount = 2,
                                                   .pDynamicStates = dynamic_states};
    const VkPipelineRenderingCreateInfo rendering{.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                                  .colorAttachmentCount = has_colour ? 1u : 0u,
                                                  .pColorAttachmentFormats = &desc.colour,
                                                  .depthAttachmentFormat =
                                                      desc.depth ? VK_FORMAT_D32_SFLOAT : VK_FORMAT_UNDEFINED};
    const VkGraphicsPipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                            .pNext = &rendering,
                                            .stageCount = static_cast<uint32_t>(stages.size()),
                                            .pStages = stages.data(),
                                            .pVertexInputState = &input,
                                            .pInputAssemblyState = &assembly,
                                            .pViewportState = &viewport,
                                            .pRasterizationState = &raster,
                                            .pMultisampleState = &samples,
                                            .pDepthStencilState = &depth,
                                            .pColorBlendState = &blend,
                                            .pDynamicState = &dynamic,
                                            .layout = desc.layout};
    const std::string doing = std::string("create the pipeline \"") + desc.name + "\"";
    check(vkCreateGraphicsPipelines(device_, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_), doing.c_str());
    device.set_name(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<uint64_t>(pipeline_), desc.name);
}

Pipeline::Pipeline(const Device& device, const char* name, VkPipelineLayout layout, std::span<const uint32_t> compute)
    : device_(device.handle()) {
    const ShaderModule module(device_, compute);
    const VkComputePipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                           .stage = stage_info(VK_SHADER_STAGE_COMPUTE_BIT, module, nullptr),
                                           .layout = layout};
    const std::string doing = std::string("create the pipeline \"") + name + "\"";
    check(vkCreateComputePipelines(device_, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_), doing.c_str());
    device.set_name(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<uint64_t>(pipeline_), name);
}

Pipeline::~Pipeline() {
    if (pipeline_) vkDestroyPipeline(device_, pipeline_, nullptr);
}

void begin_rendering(VkCommandBuffer commands, const Rendering& rendering) {
    const bool resolve = rendering.resolve != VK_NULL_HANDLE;
    const VkRenderingAttachmentInfo colour{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                           .imageView = rendering.colour,
                                           .imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
                                           .resolveMode = resolve ? VK_RESOLVE_MODE_AVERAGE_BIT : VK_RESOLVE_MODE_NONE,
                                           .resolveImageView = rendering.resolve,
                                           .resolveImageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
                                           .loadOp = rendering.colour_load,
                                           .storeOp = resolve ? VK_ATTACHMENT_STORE_OP_DONT_CARE
                                                              : VK_ATTACHMENT_STORE_OP_STORE};
    const VkRenderingAttachmentInfo depth{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                          .imageView = rendering.depth,
                                          .imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
                                          .loadOp = rendering.depth_load,
                                          .storeOp = rendering.depth_store,
                                          .clearValue = {.depthStencil = {1.0f, 0}}};
    const VkRect2D area{{0, 0}, rendering.extent};
    const VkRenderingInfo info{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                               .renderArea = area,
                               .layerCount = 1,
                               .colorAttachmentCount = rendering.colour ? 1u : 0u,
                               .pColorAttachments = &colour,
                               .pDepthAttachment = rendering.depth ? &depth : nullptr};
    vkCmdBeginRendering(commands, &info);
    const VkViewport viewport{0.0f, 0.0f, static_cast<float>(area.extent.width), static_cast<float>(area.extent.height),
                              0.0f, 1.0f};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, rendering.scissor ? &*rendering.scissor : &area);
}

} // namespace brittle::engine
