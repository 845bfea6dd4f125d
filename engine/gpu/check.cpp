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

void check(VkResult result, const char* doing) {
    if (result >= 0) return;
    const bool memory = result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY;
    throw VulkanFailure{{memory ? Status::out_of_memory : Status::device_failure,
                         std::string("cannot ") + doing + ": " + to_string(result) + " (VkResult "
                             + std::to_string(static_cast<int>(result)) + ")"}};
}

} // namespace brittle::engine
