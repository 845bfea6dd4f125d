// The one table from the frame graph's Access to Vulkan's stages, access masks, layouts and usage.
// Synchronization masks are written nowhere else.
#pragma once

#include <vulkan/vulkan.h>

#include "engine/graph/plan.h"

namespace brittle::engine {

struct VulkanAccess {
    VkPipelineStageFlags2 stages = 0;
    VkAccessFlags2 access = 0;
    VkImageUsageFlags image_usage = 0;
    VkBufferUsageFlags buffer_usage = 0;
};

[[nodiscard]] VulkanAccess to_vulkan(Access access);
[[nodiscard]] VulkanAccess to_vulkan(AccessSet set); // the union over its members
[[nodiscard]] VkImageLayout to_vulkan(Layout layout);
[[nodiscard]] VkFormat to_vulkan(Format format);

} // namespace brittle::engine
