#include "engine/gpu/swapchain.h"

#include <algorithm>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "engine/core/window.h"
#include "engine/gpu/check.h"
#include "engine/gpu/device.h"
#include "engine/gpu/enumerate.h"
#include "engine/gpu/memory.h"

namespace brittle::engine {

namespace {

// The longest wait for an image that the window system holds, in nanoseconds.
constexpr uint64_t acquire_timeout = 1'000'000'000;

constexpr const char* alternatives =
    ". Choose another device, or draw the same pictures into files by `brittle render`.";

VkSemaphore create_semaphore(VkDevice device) {
    const VkSemaphoreCreateInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    VkSemaphore semaphore = VK_NULL_HANDLE;
    check(vkCreateSemaphore(device, &info, nullptr, &semaphore), "create a semaphore");
    return semaphore;
}

} // namespace

VkExtent2D choose_extent(const VkSurfaceCapabilitiesKHR& capabilities, glm::uvec2 framebuffer_size) {
    if (capabilities.currentExtent.width != UINT32_MAX) return capabilities.currentExtent;
    // The surface takes its size from the swapchain. The limits of a hidden surface may all be zero.
    return {std::clamp(framebuffer_size.x, capabilities.minImageExtent.width, capabilities.maxImageExtent.width),
            std::clamp(framebuffer_size.y, capabilities.minImageExtent.height, capabilities.maxImageExtent.height)};
}

VkPresentModeKHR choose_present_mode(std::span<const VkPresentModeKHR> offered, bool vsync) {
    if (!vsync)
        for (VkPresentModeKHR wanted : {VK_PRESENT_MODE_MAILBOX_KHR, VK_PRESENT_MODE_IMMEDIATE_KHR})
            if (std::ranges::find(offered, wanted) != offered.end()) return wanted;
    return VK_PRESENT_MODE_FIFO_KHR;
}

Swapchain::Swapchain(const Device& device, const Window& window, bool vsync, uint32_t frames)
    : device_(device), window_(window), vsync_(vsync), frames_(frames) {
    if (!device.can_present())
        throw VulkanFailure{{Status::missing_feature, "the Vulkan device " + device.info().name
                                                          + " cannot show anything in a window" + alternatives}};
    try {
        create_surface();
        choose_format();
    } catch (...) {
        destroy_surface();
        throw;
    }
}

Swapchain::~Swapchain() {
    device_.wait_idle();
    destroy_surface();
}

void Swapchain::create_surface() {
    check(glfwCreateWindowSurface(device_.instance(), window_.handle(), nullptr, &surface_),
          "create a Vulkan surface for the window");
    VkBool32 supported = VK_FALSE;
    check(vkGetPhysicalDeviceSurfaceSupportKHR(device_.physical(), device_.queue_family(), surface_, &supported),
          "query whether the device can present to the window");
    if (!supported)
        throw VulkanFailure{{Status::missing_feature, "the Vulkan device " + device_.info().name
                                                          + " cannot present to this window" + alternatives}};
}

void Swapchain::destroy_surface() {
    destroy_images();
    if (swapchain_) vkDestroySwapchainKHR(device_.handle(), swapchain_, nullptr);
    if (surface_) vkDestroySurfaceKHR(device_.instance(), surface_, nullptr);
    swapchain_ = VK_NULL_HANDLE;
    surface_ = VK_NULL_HANDLE;
}

void Swapchain::choose_format() {
    const auto formats = enumerate<VkSurfaceFormatKHR>([&](uint32_t* count, VkSurfaceFormatKHR* elements) {
        check(vkGetPhysicalDeviceSurfaceFormatsKHR(device_.physical(), surface_, count, elements),
              "list the window's formats");
    });
    for (const VkSurfaceFormatKHR& offered : formats) {
        if (offered.colorSpace != VK_COLOR_SPACE_SRGB_NONLINEAR_KHR) continue;
        if (offered.format != VK_FORMAT_B8G8R8A8_UNORM && offered.format != VK_FORMAT_R8G8B8A8_UNORM) continue;
        surface_format_ = offered;
        format_ = offered.format == VK_FORMAT_B8G8R8A8_UNORM ? Format::bgra8_unorm : Format::rgba8_unorm;
        return;
    }
    throw VulkanFailure{{Status::missing_feature, "the window offers no 8-bit UNORM colour format"}};
}

bool Swapchain::fit(glm::uvec2 framebuffer_size) {
    if (stale_ || image_held_ || framebuffer_size != created_for_) {
        device_.wait_idle();
        if (surface_lost_) {
            destroy_surface();
            create_surface(); // for the same window, so the format stays valid
            surface_lost_ = false;
        }
        create_swapchain(framebuffer_size);
    }
    return never_acquired_;
}

void Swapchain::create_swapchain(glm::uvec2 framebuffer_size) {
    VkSurfaceCapabilitiesKHR capabilities;
    check(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_.physical(), surface_, &capabilities),
          "query the window's surface capabilities");
    extent_ = choose_extent(capabilities, framebuffer_size);
    created_for_ = framebuffer_size;
    destroy_images();
    image_held_ = false;
    never_acquired_ = true;
    stale_ = true; // until all objects exist; the window may also have shrunk to nothing since its size was queried
    if (extent_.width == 0 || extent_.height == 0) return;

    const auto modes = enumerate<VkPresentModeKHR>([&](uint32_t* count, VkPresentModeKHR* elements) {
        check(vkGetPhysicalDeviceSurfacePresentModesKHR(device_.physical(), surface_, count, elements),
              "list the window's present modes");
    });
    const VkCompositeAlphaFlagBitsKHR alpha = capabilities.supportedCompositeAlpha & VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                                                  ? VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                                                  : VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR;
    const uint32_t max_images = capabilities.maxImageCount == 0 ? UINT32_MAX : capabilities.maxImageCount;
    supports_transfer_ = capabilities.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_DST_BIT; // nearly everywhere
    VkImageUsageFlags usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    if (supports_transfer_) usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    const VkSwapchainKHR old = swapchain_;
    const VkSwapchainCreateInfoKHR info{.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
                                        .surface = surface_,
                                        .minImageCount = std::min(std::max(capabilities.minImageCount, 3u), max_images),
                                        .imageFormat = surface_format_.format,
                                        .imageColorSpace = surface_format_.colorSpace,
                                        .imageExtent = extent_,
                                        .imageArrayLayers = 1,
                                        .imageUsage = usage,
                                        .imageSharingMode = VK_SHARING_MODE_EXCLUSIVE,
                                        .preTransform = capabilities.currentTransform,
                                        .compositeAlpha = alpha,
                                        .presentMode = choose_present_mode(modes, vsync_),
                                        .clipped = VK_TRUE,
                                        .oldSwapchain = old};
    swapchain_ = VK_NULL_HANDLE;
    const VkResult result = device_.attempt(
        Call::create_swapchain, [&] { return vkCreateSwapchainKHR(device_.handle(), &info, nullptr, &swapchain_); });
    if (old) vkDestroySwapchainKHR(device_.handle(), old, nullptr);
    if (result < 0) swapchain_ = VK_NULL_HANDLE;
    if (is_recoverable(result)) return;
    check(result, "create a swapchain");

    images_ = enumerate<VkImage>([&](uint32_t* count, VkImage* elements) {
        check(vkGetSwapchainImagesKHR(device_.handle(), swapchain_, count, elements), "list the swapchain's images");
    });
    for (VkImage image : images_) {
        views_.push_back(create_view(device_.handle(), image, surface_format_.format));
        finished_.push_back(create_semaphore(device_.handle()));
    }
    for (uint32_t frame = 0; frame < frames_; ++frame) acquired_.push_back(create_semaphore(device_.handle()));
    stale_ = false;
}

void Swapchain::destroy_images() {
    for (VkImageView view : views_) vkDestroyImageView(device_.handle(), view, nullptr);
    for (VkSemaphore semaphore : finished_) vkDestroySemaphore(device_.handle(), semaphore, nullptr);
    for (VkSemaphore semaphore : acquired_) vkDestroySemaphore(device_.handle(), semaphore, nullptr);
    images_.clear();
    views_.clear();
    finished_.clear();
    acquired_.clear();
}

// Returns whether the next fit() recovers from the result, and marks the swapchain for it.
bool Swapchain::is_recoverable(VkResult result) {
    switch (result) {
    case VK_ERROR_SURFACE_LOST_KHR:
        surface_lost_ = true;
        [[fallthrough]];
    case VK_ERROR_OUT_OF_DATE_KHR:
        stale_ = true;
        return true;
    default:
        return false;
    }
}

std::optional<uint32_t> Swapchain::acquire(uint32_t frame) {
    if (stale_) return std::nullopt;
    uint32_t image = 0;
    const VkResult result = device_.attempt(Call::acquire, [&] {
        return vkAcquireNextImageKHR(device_.handle(), swapchain_, acquire_timeout, acquired_[frame], VK_NULL_HANDLE,
                                     &image);
    });
    if (is_recoverable(result) || result == VK_TIMEOUT || result == VK_NOT_READY) return std::nullopt;
    check(result, "acquire a swapchain image");
    suboptimal_ = result == VK_SUBOPTIMAL_KHR; // a success code: this frame is still drawn
    never_acquired_ = false;
    image_held_ = true;
    return image;
}

void Swapchain::present(uint32_t image) {
    const VkPresentInfoKHR info{.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                                .waitSemaphoreCount = 1,
                                .pWaitSemaphores = &finished_[image],
                                .swapchainCount = 1,
                                .pSwapchains = &swapchain_,
                                .pImageIndices = &image};
    const VkResult result = device_.attempt(Call::present, [&] {
        return device_.with_queue([&](VkQueue queue) { return vkQueuePresentKHR(queue, &info); });
    });
    if (!is_recoverable(result)) check(result, "present a frame");
    image_held_ = false;
    // Recreated once only, because some systems report every swapchain as suboptimal.
    suboptimal_ = suboptimal_ || result == VK_SUBOPTIMAL_KHR;
    if (suboptimal_ && !recreated_suboptimal_) stale_ = true;
    recreated_suboptimal_ = suboptimal_;
}

} // namespace brittle::engine
