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

// Each frame calls fit(), acquire(), submits, and calls present(). The format is UNORM, because the shaders and Dear
// ImGui write sRGB themselves. All functions throw VulkanFailure.
//
// fit() compares the window's size with the swapchain's, because some systems never report an out-of-date swapchain
// after a resize. It does so before an image is acquired, when there is nothing to undo.
//
// The next fit() recovers from a swapchain that is out of date or suboptimal, from a lost surface, and from a frame
// that failed between acquire() and present(), whose image and semaphore it discards.
class Swapchain {
  public:
    // `frames`: the number of frames in flight. Fails with missing_feature when the device cannot present to the
    // window.
    Swapchain(const Device& device, const Window& window, bool vsync, uint32_t frames);
    ~Swapchain();
    Swapchain(const Swapchain&) = delete;
    Swapchain& operator=(const Swapchain&) = delete;

    // Recreates the swapchain when the window's size has changed or the swapchain is unusable; then it waits for the
    // device. Returns whether the images are new: true until an image is acquired, so that the caller recreates objects
    // that depend on the images even after a failed attempt. The size must not be zero.
    bool fit(glm::uvec2 framebuffer_size);

    // Acquires the next image, which is ready once acquired(frame) is signalled. `frame` is the index of the frame in
    // flight; the device must have finished its previous frame of that index. Returns nullopt when fit() must run
    // first, or when the window system holds all images for a second, as some do for a hidden window.
    [[nodiscard]] std::optional<uint32_t> acquire(uint32_t frame);
    [[nodiscard]] VkSemaphore acquired(uint32_t frame) const { return acquired_[frame]; }
    // Returns the semaphore that the frame's submission signals for present(). There is one for each image, because
    // only a new acquire of an image proves that its previous presentation has finished with the semaphore.
    [[nodiscard]] VkSemaphore finished(uint32_t image) const { return finished_[image]; }
    void present(uint32_t image);

    [[nodiscard]] Format format() const { return format_; }
    [[nodiscard]] VkExtent2D extent() const { return extent_; }
    [[nodiscard]] bool supports_transfer() const { return supports_transfer_; } // images may be transfer targets
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
    glm::uvec2 created_for_{0};         // the framebuffer size at creation; the surface may prescribe another extent
    bool stale_ = true;                 // the swapchain must be recreated
    bool never_acquired_ = false;       // no image was acquired since the swapchain was created
    bool image_held_ = false;           // an image is acquired and not presented
    bool surface_lost_ = false;         // the surface must be recreated, too
    bool suboptimal_ = false;           // the last acquire() or present() reported it
    bool recreated_suboptimal_ = false; // the present swapchain is the recreation of a suboptimal one
    std::vector<VkImage> images_;
    std::vector<VkImageView> views_;
    std::vector<VkSemaphore> finished_; // by image
    std::vector<VkSemaphore> acquired_; // by frame in flight
};

// Returns the extent that the surface prescribes or, if it leaves the choice, the window's size clamped to its limits.
// A side is zero when the surface cannot be drawn into at present.
[[nodiscard]] VkExtent2D choose_extent(const VkSurfaceCapabilitiesKHR& capabilities, glm::uvec2 framebuffer_size);

// Returns FIFO, which every driver has, for vsync; otherwise the first of mailbox and immediate that is offered, or
// FIFO.
[[nodiscard]] VkPresentModeKHR choose_present_mode(std::span<const VkPresentModeKHR> offered, bool vsync);

} // namespace brittle::engine
