#include "engine/gpu/check.h"

#include <string>

namespace brittle::engine {

const char* to_string(VkResult result) {
    switch (result) {
    case VK_SUCCESS:
        return "success";
    case VK_NOT_READY:
        return "not ready";
    case VK_TIMEOUT:
        return "timed out";
    case VK_ERROR_OUT_OF_HOST_MEMORY:
        return "out of host memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        return "out of device memory";
    case VK_ERROR_INITIALIZATION_FAILED:
        return "initialization failed";
    case VK_ERROR_DEVICE_LOST:
        return "the device was lost";
    case VK_ERROR_MEMORY_MAP_FAILED:
        return "memory could not be mapped";
    case VK_ERROR_LAYER_NOT_PRESENT:
        return "layer not present";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
        return "extension not present";
    case VK_ERROR_FEATURE_NOT_PRESENT:
        return "feature not present";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
        return "no compatible driver";
    case VK_ERROR_TOO_MANY_OBJECTS:
        return "too many objects";
    case VK_ERROR_FORMAT_NOT_SUPPORTED:
        return "format not supported";
    case VK_ERROR_SURFACE_LOST_KHR:
        return "the surface was lost";
    case VK_ERROR_OUT_OF_DATE_KHR:
        return "the swapchain is out of date";
    case VK_SUBOPTIMAL_KHR:
        return "the swapchain is suboptimal";
    default:
        return "unexpected result";
    }
}

namespace {

Status status_of(VkResult result) {
    switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        return Status::out_of_memory;
    case VK_ERROR_DEVICE_LOST:
        return Status::device_lost;
    default:
        return Status::device_failure;
    }
}

// The end of the message: advice to the user, or nothing.
const char* advice_on(VkResult result) {
    switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
        return ". Close other programs, or use a smaller mesh or fewer pieces.";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        return ". Close other programs that use the device, use a smaller mesh, fewer pieces or a smaller"
               " picture, or another device.";
    case VK_ERROR_DEVICE_LOST:
        return ". Its driver gave up on it, or it was removed: start again. If it happens again, update the"
               " driver or choose another device.";
    default:
        return "";
    }
}

} // namespace

void check(VkResult result, const char* doing) {
    if (result >= 0) return;
    throw VulkanFailure{{status_of(result), std::string("cannot ") + doing + ": " + to_string(result) + " (VkResult "
                                                + std::to_string(static_cast<int>(result)) + ")" + advice_on(result)}};
}

} // namespace brittle::engine
