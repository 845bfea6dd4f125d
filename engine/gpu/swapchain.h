// A window's surface and the images that are presented to it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <vulkan/vulkan.h>

#include "engine/core/format.h"

namespace brittle::engine {

class Device;
class Window;

// UNORM formats only: shaders and Dear ImGui write sRGB themselves. All functions throw VulkanFailure.
//
// Each frame: fit() to the window, acquire(), submit, present(). Some systems never say that a swapchain is
// out of date after a resize, hence fit() compares sizes itself, before an image is acquired, when nothing
// has to be undone.
//
// What the window system does to it (out of date, suboptimal, a surface lost) is mended by the next fit().
// So is a frame that failed between acquire() and present(): its image and semaphore are thrown away.
class Swapchain {
  public:
    // `frames`: how many frames are in flight.
    Swapchain(const Device& device, const Window& window, bool vsync, uint32_t frames);
    ~Swapchain();
    Swapchain(const Swapchain&) = delete;
    Swapchain& operator=(const Swapchain&) = delete;

    // Remakes the swapchain if the window's size changed or the system wants it, waiting for the device. True
    // until an image of the new ones is acquired, so that what is made for them is made again if that fails.
    // The size must not be zero.
    bool fit(glm::uvec2 framebuffer_size);

    // The next image, ready once acquired(frame) is signalled, where `frame` is below the constructor's and
    // the device is done with its last turn. None when the swapchain must be fitted again first, or when the
    // window system keeps all images for a second, as some do for a hidden window.
    [[nodiscard]] std::optional<uint32_t> acquire(uint32_t frame);
    [[nodiscard]] VkSemaphore acquired(uint32_t frame) const { return acquired_[frame]; }
    // The semaphore that the frame's submission signals for present(): one an image, since only acquiring an
    // image again proves that its previous presentation has waited.
    [[nodiscard]] VkSemaphore finished(uint32_t image) const { return finished_[image]; }
    void present(uint32_t image);

    [[nodiscard]] Format format() const { return format_; }
    [[nodiscard]] VkExtent2D extent() const { return extent_; }
    [[nodiscard]] bool supports_transfer() const { return supports_transfer_; } // as targets of transfers
    [[nodiscard]] const std::vector<VkImage>& images() const { return images_; }
    [[nodiscard]] const std::vector<VkImageView>& views() const { return views_; }

  private:
    void create_surface();
    void destroy_surface();
    void choose_format();
    void create_swapchain(glm::uvec2 framebuffer_size);
    void destroy_images();
    [[nodiscard]] bool is_recoverable(VkResult result);

    const Device& device_;
    const Window& window_;
    bool vsync_;
    uint32_t frames_;
    VkSurfaceKHR surface_ = VK_NULL_HANDLE;
    VkSurfaceFormatKHR surface_format_{};
    Format format_ = Format::bgra8_unorm;
    VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
    VkExtent2D extent_{};
    bool supports_transfer_ = false;
    glm::uvec2 created_for_{0};   // the framebuffer size at the time; the surface may have insisted on another extent
    bool stale_ = true;           // to be made again
    bool never_acquired_ = false; // no image was acquired since it was made
    bool image_held_ = false;     // an image is acquired and not presented
    bool surface_lost_ = false;   // to be made again with its surface
    bool suboptimal_ = false;     // as the last acquire() or present() said
    bool recreated_suboptimal_ = false; // making it again did not help: leave it at that
    std::vector<VkImage> images_;
    std::vector<VkImageView> views_;
    std::vector<VkSemaphore> finished_; // by image
    std::vector<VkSemaphore> acquired_; // by frame in flight
};

// The extent that the surface insists on, or the window's size within what it allows; zero in a side where
// there is nothing to draw into now.
[[nodiscard]] VkExtent2D choose_extent(const VkSurfaceCapabilitiesKHR& capabilities, glm::uvec2 framebuffer_size);

// With vsync FIFO, which every driver has; without it the first offered of mailbox and immediate, else FIFO.
[[nodiscard]] VkPresentModeKHR choose_present_mode(std::span<const VkPresentModeKHR> offered, bool vsync);

} // namespace brittle::engine
