// The user interface pass: draws Dear ImGui over the finished picture.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <vulkan/vulkan.h>

#include "engine/render/frame.h"

namespace brittle::engine {

class Swapchain;
class Window;

// Debian's Dear ImGui 1.86 supports no dynamic rendering, so this pass has the only render pass and framebuffers of the
// engine. The render pass makes no layout transition; the frame graph makes them all.
//
// Dear ImGui has one context in a process, so only one UiPass may exist at a time. Main thread only.
class UiPass {
  public:
    // Installs Dear ImGui's callbacks, which call the window's own. `prepare` may set fonts and style; it is called
    // before the fonts are uploaded. Throws VulkanFailure.
    UiPass(const Device& device, const Window& window, const Swapchain& swapchain,
           const std::function<void()>& prepare = {});
    ~UiPass(); // the device must be idle
    UiPass(const UiPass&) = delete;
    UiPass& operator=(const UiPass&) = delete;

    void fit(const Swapchain& swapchain); // recreates the framebuffers for new images; the device must be idle

    // Starts a Dear ImGui frame and calls `ui`, which may be empty. Once in each frame, before declare().
    void build(const std::function<void()>& ui);
    void declare(Frame& frame, uint32_t swapchain_image) const;

  private:
    void create_render_pass(VkFormat format);
    void start_imgui(const Window& window, const std::function<void()>& prepare);
    void destroy_framebuffers();
    void destroy();

    const Device& device_;
    VkRenderPass render_pass_ = VK_NULL_HANDLE;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    std::vector<VkFramebuffer> framebuffers_;
};

} // namespace brittle::engine
