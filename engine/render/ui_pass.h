// The user interface: Dear ImGui over the finished picture.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <vulkan/vulkan.h>

#include "engine/render/frame.h"

namespace brittle::engine {

class Swapchain;
class Window;

// Debian's Dear ImGui 1.86 draws in classic render passes only, hence the one render pass and the
// framebuffers of this code base. It takes the image as the frame graph hands it over and leaves it so: the
// render pass has no transition.
//
// Dear ImGui has one context a process; so there is one UiPass at a time.
class UiPass {
  public:
    // The window's own callbacks are installed by now, and Dear ImGui's call them on. `prepare`, if any, chooses fonts
    // and style, before the fonts are uploaded. Throws VulkanFailure.
    UiPass(const Device& device, const Window& window, const Swapchain& swapchain,
           const std::function<void()>& prepare = {});
    ~UiPass(); // the device must be idle
    UiPass(const UiPass&) = delete;
    UiPass& operator=(const UiPass&) = delete;

    void fit(const Swapchain& swapchain); // after the swapchain was remade; the device must be idle

    // Runs the callback, which makes Dear ImGui calls. Once a frame, before declare().
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
