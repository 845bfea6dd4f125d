#include "engine/render/ui_pass.h"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_vulkan.h>
#include <imgui.h>

#include "engine/core/window.h"
#include "engine/gpu/check.h"
#include "engine/gpu/commands.h"
#include "engine/gpu/swapchain.h"
#include "engine/graph/access_vulkan.h"

namespace brittle::engine {

UiPass::UiPass(const Device& device, const Window& window, const Swapchain& swapchain,
               const std::function<void()>& prepare)
    : device_(device) {
    try {
        create_render_pass(to_vulkan(swapchain.format()));
        start_imgui(window, prepare);
    } catch (...) {
        destroy();
        throw;
    }
}

UiPass::~UiPass() {
    destroy();
}

void UiPass::destroy() {
    if (ImGui::GetCurrentContext()) {
        if (ImGui::GetIO().BackendRendererUserData) ImGui_ImplVulkan_Shutdown();
        if (ImGui::GetIO().BackendPlatformUserData) ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext();
    }
    destroy_framebuffers();
    vkDestroyDescriptorPool(device_.handle(), pool_, nullptr);
    vkDestroyRenderPass(device_.handle(), render_pass_, nullptr);
}

void UiPass::create_render_pass(VkFormat format) {
    const VkAttachmentDescription attachment{.format = format,
                                             .samples = VK_SAMPLE_COUNT_1_BIT,
                                             .loadOp = VK_ATTACHMENT_LOAD_OP_LOAD,
                                             .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                             .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                             .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                             .initialLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
                                             .finalLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL};
    const VkAttachmentReference reference{0, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL};
    const VkSubpassDescription subpass{.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                       .colorAttachmentCount = 1,
                                       .pColorAttachments = &reference};
    const VkRenderPassCreateInfo info{.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                      .attachmentCount = 1,
                                      .pAttachments = &attachment,
                                      .subpassCount = 1,
                                      .pSubpasses = &subpass};
    check(vkCreateRenderPass(device_.handle(), &info, nullptr, &render_pass_), "create a render pass");
}

void UiPass::start_imgui(const Window& window, const std::function<void()>& prepare) {
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 8};
    const VkDescriptorPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                          .flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT,
                                          .maxSets = 8,
                                          .poolSizeCount = 1,
                                          .pPoolSizes = &size};
    check(vkCreateDescriptorPool(device_.handle(), &pool, nullptr, &pool_), "create a descriptor pool");

    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr; // no files in the user's working folder
    if (prepare) prepare();
    ImGui_ImplGlfw_InitForVulkan(window.handle(), true);
    ImGui_ImplVulkan_InitInfo info{};
    info.Instance = device_.instance();
    info.PhysicalDevice = device_.physical();
    info.Device = device_.handle();
    info.QueueFamily = device_.queue_family();
    device_.with_queue([&](VkQueue queue) { info.Queue = queue; }); // used only during initialisation
    info.DescriptorPool = pool_;
    info.MinImageCount = 2;
    info.ImageCount = 3; // number of vertex buffers in rotation; must exceed the frames in flight
    info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
    // The callback could not throw through Dear ImGui's code; a lost device fails again in the engine's next own call.
    info.CheckVkResultFn = nullptr;
    ImGui_ImplVulkan_Init(&info, render_pass_);

    CommandSlot commands(device_);
    commands.begin();
    ImGui_ImplVulkan_CreateFontsTexture(commands.buffer());
    commands.submit({}, VK_NULL_HANDLE);
    commands.wait();
    ImGui_ImplVulkan_DestroyFontUploadObjects();
}

void UiPass::destroy_framebuffers() {
    for (VkFramebuffer framebuffer : framebuffers_) vkDestroyFramebuffer(device_.handle(), framebuffer, nullptr);
    framebuffers_.clear();
}

void UiPass::fit(const Swapchain& swapchain) {
    destroy_framebuffers();
    for (const VkImageView& view : swapchain.views()) {
        const VkFramebufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                           .renderPass = render_pass_,
                                           .attachmentCount = 1,
                                           .pAttachments = &view,
                                           .width = swapchain.extent().width,
                                           .height = swapchain.extent().height,
                                           .layers = 1};
        VkFramebuffer framebuffer = VK_NULL_HANDLE;
        check(vkCreateFramebuffer(device_.handle(), &info, nullptr, &framebuffer), "create a framebuffer");
        framebuffers_.push_back(framebuffer);
    }
}

void UiPass::build(const std::function<void()>& ui) {
    ImGui_ImplVulkan_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    if (ui) ui();
    ImGui::Render();
}

void UiPass::declare(Frame& frame, uint32_t swapchain_image) const {
    frame.graph.add_pass(
        "ui", PassKind::graphics,
        [&](PassBuilder& pass) { frame.picture = pass.write(frame.picture, Access::colour_attachment_load); },
        [this, &frame, swapchain_image](PassContext& context) {
            const VkRenderPassBeginInfo info{.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                             .renderPass = render_pass_,
                                             .framebuffer = framebuffers_[swapchain_image],
                                             .renderArea = {{0, 0}, context.extent(frame.picture)}};
            vkCmdBeginRenderPass(context.commands, &info, VK_SUBPASS_CONTENTS_INLINE);
            ImGui_ImplVulkan_RenderDrawData(ImGui::GetDrawData(), context.commands);
            vkCmdEndRenderPass(context.commands);
        });
}

} // namespace brittle::engine
