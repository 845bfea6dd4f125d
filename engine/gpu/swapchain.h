// A window's surface and the images that are presented to it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>
#include <vulkan/vulkan.h>

#include "engine/graph/plan.h"

namespace brittle::engine {

class Device;
class Window;

// UNORM formats only: shaders and Dear ImGui write sRGB themselves. All functions throw VulkanFailure.
//
// Each frame: fit() to the window, acquire(), submit, present(). Some systems never say that a swapchain is
// out of date after a resize, hence fit() compares sizes itself, before an image is acquired, when nothing
// has to be undone.
class Swapchain {
  public:
    Swapchain(const Device& device, const Window& window, bool vsync);
    ~Swapchain();
    Swapchain(const Swapchain&) = delete;
    Swapchain& operator=(const Swapchain&) = delete;

    // Remakes the swapchain if the window's size changed or the system wants it, waiting for the device; true
    // if it did. The size must not be zero.
    bool fit(glm::uvec2 framebuffer_size);

    // The next image, ready once `semaphore` is signalled; none when the swapchain must be fitted again
    // first.
    [[nodiscard]] std::optional<uint32_t> acquire(VkSemaphore semaphore);
    // The semaphore that the frame's submission signals for present(): one an image, since only acquiring an
    // image again proves that its previous presentation has waited.
    [[nodiscard]] VkSemaphore finished(uint32_t image) const { return finished_[image]; }
    void present(uint32_t image);

    [[nodiscard]] Format format() const { return format_; }
    [[nodiscard]] VkExtent2D extent() const { return extent_; }
    [[nodiscard]] const std::vector<VkImage>& images() const { return images_; }
    [[nodiscard]] const std::vector<VkImageView>& views() const { return views_; }

  private:
    void choose_format();
    void make(glm::uvec2 framebuffer_size);
    void destroy_images();

    const Device& device_;
    bool vsync_;
    VkSurfaceKHR surface_ = VK_NULL_HANDLE;
    VkSurfaceFormatKHR surface_format_{};
    Format format_ = Format::bgra8_unorm;
    VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
    VkExtent2D extent_{};
    glm::uvec2 made_for_{
        0}; // the framebuffer size at the time; the surface may have insisted on another extent
    bool stale_ = true;
    std::vector<VkImage> images_;
    std::vector<VkImageView> views_;
    std::vector<VkSemaphore> finished_;
};

} // namespace brittle::engine
