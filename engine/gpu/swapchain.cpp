#include "engine/gpu/swapchain.h"

#include <algorithm>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "engine/core/window.h"
#include "engine/gpu/check.h"
#include "engine/gpu/device.h"
#include "engine/gpu/memory.h"

namespace brittle::engine {

Swapchain::Swapchain(const Device& device, const Window& window, bool vsync)
    : device_(device), vsync_(vsync) {
    if (!device.can_present())
        throw VulkanFailure{{Status::missing_feature, "the Vulkan device " + device.info().name
                                                          + " cannot show anything in a window"}};
    check(glfwCreateWindowSurface(device.instance(), window.handle(), nullptr, &surface_),
          "create a Vulkan surface for the window");
    try {
        VkBool32 supported = VK_FALSE;
        check(vkGetPhysicalDeviceSurfaceSupportKHR(device.physical(), device.queue_family(), surface_,
                                                   &supported),
              "ask whether the device can present to the window");
        if (!supported)
            throw VulkanFailure{{Status::missing_feature, "the Vulkan device " + device.info().name
                                                              + " cannot present to this window"}};
        choose_format();
    } catch (...) {
        vkDestroySurfaceKHR(device.instance(), surface_, nullptr);
        throw;
    }
}

Swapchain::~Swapchain() {
    device_.wait_idle();
    destroy_images();
    if (swapchain_) vkDestroySwapchainKHR(device_.handle(), swapchain_, nullptr);
    vkDestroySurfaceKHR(device_.instance(), surface_, nullptr);
}

void Swapchain::choose_format() {
    uint32_t count = 0;
    check(vkGetPhysicalDeviceSurfaceFormatsKHR(device_.physical(), surface_, &count, nullptr),
          "list the window's formats");
    std::vector<VkSurfaceFormatKHR> formats(count);
    check(vkGetPhysicalDeviceSurfaceFormatsKHR(device_.physical(), surface_, &count, formats.data()),
          "list the window's formats");
    for (const VkSurfaceFormatKHR& offered : formats) {
        if (offered.colorSpace != VK_COLOR_SPACE_SRGB_NONLINEAR_KHR) continue;
        if (offered.format != VK_FORMAT_B8G8R8A8_UNORM && offered.format != VK_FORMAT_R8G8B8A8_UNORM)
            continue;
        surface_format_ = offered;
        format_ = offered.format == VK_FORMAT_B8G8R8A8_UNORM ? Format::bgra8_unorm : Format::rgba8_unorm;
        return;
    }
    throw VulkanFailure{{Status::missing_feature, "the window offers no 8-bit UNORM colour format"}};
}

bool Swapchain::fit(glm::uvec2 framebuffer_size) {
    if (!stale_ && framebuffer_size == made_for_) return false;
    device_.wait_idle();
    make(framebuffer_size);
    return true;
}

void Swapchain::make(glm::uvec2 framebuffer_size) {
    VkSurfaceCapabilitiesKHR can;
    check(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_.physical(), surface_, &can),
          "ask for the window's capabilities");
    extent_ = can.currentExtent;
    if (extent_.width == UINT32_MAX) // the surface takes the size from the swapchain
        extent_ = {std::clamp(framebuffer_size.x, can.minImageExtent.width, can.maxImageExtent.width),
                   std::clamp(framebuffer_size.y, can.minImageExtent.height, can.maxImageExtent.height)};
    made_for_ = framebuffer_size;
    destroy_images();
    stale_ = true; // until all is made; a window can also shrink to nothing between the two questions
    if (extent_.width == 0 || extent_.height == 0) return;

    uint32_t count = 0;
    check(vkGetPhysicalDeviceSurfacePresentModesKHR(device_.physical(), surface_, &count, nullptr),
          "list the window's present modes");
    std::vector<VkPresentModeKHR> modes(count);
    check(vkGetPhysicalDeviceSurfacePresentModesKHR(device_.physical(), surface_, &count, modes.data()),
          "list the window's present modes");
    VkPresentModeKHR mode = VK_PRESENT_MODE_FIFO_KHR; // the one that every driver has
    if (!vsync_)
        for (VkPresentModeKHR wanted : {VK_PRESENT_MODE_IMMEDIATE_KHR, VK_PRESENT_MODE_MAILBOX_KHR})
            if (std::ranges::find(modes, wanted) != modes.end()) mode = wanted;

    const VkCompositeAlphaFlagBitsKHR alpha = can.supportedCompositeAlpha & VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                                                  ? VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                                                  : VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR;
    const uint32_t most = can.maxImageCount == 0 ? UINT32_MAX : can.maxImageCount;
    const VkSwapchainKHR old = swapchain_;
    const VkSwapchainCreateInfoKHR info{.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
                                        .surface = surface_,
                                        .minImageCount = std::min(std::max(can.minImageCount, 3u), most),
                                        .imageFormat = surface_format_.format,
                                        .imageColorSpace = surface_format_.colorSpace,
                                        .imageExtent = extent_,
                                        .imageArrayLayers = 1,
                                        .imageUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                                        .imageSharingMode = VK_SHARING_MODE_EXCLUSIVE,
                                        .preTransform = can.currentTransform,
                                        .compositeAlpha = alpha,
                                        .presentMode = mode,
                                        .clipped = VK_TRUE,
                                        .oldSwapchain = old};
    const VkResult result = vkCreateSwapchainKHR(device_.handle(), &info, nullptr, &swapchain_);
    if (result != VK_SUCCESS) swapchain_ = VK_NULL_HANDLE;
    if (old) vkDestroySwapchainKHR(device_.handle(), old, nullptr);
    check(result, "create a swapchain");

    check(vkGetSwapchainImagesKHR(device_.handle(), swapchain_, &count, nullptr),
          "list the swapchain's images");
    images_.resize(count);
    check(vkGetSwapchainImagesKHR(device_.handle(), swapchain_, &count, images_.data()),
          "list the swapchain's images");
    for (VkImage image : images_) {
        views_.push_back(create_view(device_.handle(), image, surface_format_.format));
        const VkSemaphoreCreateInfo semaphore{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
        VkSemaphore made = VK_NULL_HANDLE;
        check(vkCreateSemaphore(device_.handle(), &semaphore, nullptr, &made), "create a semaphore");
        finished_.push_back(made);
    }
    stale_ = false;
}

void Swapchain::destroy_images() {
    for (VkImageView view : views_) vkDestroyImageView(device_.handle(), view, nullptr);
    for (VkSemaphore semaphore : finished_) vkDestroySemaphore(device_.handle(), semaphore, nullptr);
    images_.clear();
    views_.clear();
    finished_.clear();
}

std::optional<uint32_t> Swapchain::acquire(VkSemaphore semaphore) {
    if (stale_) return std::nullopt;
    uint32_t image = 0;
    const VkResult result =
        vkAcquireNextImageKHR(device_.handle(), swapchain_, UINT64_MAX, semaphore, VK_NULL_HANDLE, &image);
    if (result == VK_ERROR_OUT_OF_DATE_KHR) {
        stale_ = true;
        return std::nullopt;
    }
    check(result, "acquire a swapchain image"); // suboptimal is a success: fit() sees a new size by itself
    return image;
}

void Swapchain::present(uint32_t image) {
    const VkPresentInfoKHR info{.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                                .waitSemaphoreCount = 1,
                                .pWaitSemaphores = &finished_[image],
                                .swapchainCount = 1,
                                .pSwapchains = &swapchain_,
                                .pImageIndices = &image};
    const VkResult result = vkQueuePresentKHR(device_.queue(), &info);
    if (result == VK_ERROR_OUT_OF_DATE_KHR) {
        stale_ = true;
        return;
    }
    check(result, "present a frame");
}

} // namespace brittle::engine
