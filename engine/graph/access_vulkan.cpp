#include "engine/graph/access_vulkan.h"

namespace brittle::engine {

namespace {

constexpr VkPipelineStageFlags2 any_shader = VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT
                                             | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT
                                             | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
constexpr VkPipelineStageFlags2 depth_stages =
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;
constexpr VkAccessFlags2 depth_access =
    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
constexpr VkAccessFlags2 storage_access = VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;
constexpr VkBufferUsageFlags storage_buffer = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
constexpr VkImageUsageFlags storage_image = VK_IMAGE_USAGE_STORAGE_BIT;

} // namespace

VulkanAccess to_vulkan(Access access) {
    switch (access) {
    // The submission waits for the acquire semaphore at this stage (Renderer::present).
    case Access::acquired:
        return {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT, 0, 0, 0};
    // All commands, like the signal of the semaphore that presentation waits for: only a common stage orders the
    // barrier's layout transition before that signal. With no stage, queue-submit validation reports a hazard.
    case Access::present:
        return {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, 0, 0, 0};
    case Access::host_write:
        return {VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_WRITE_BIT, 0, 0};
    case Access::host_read:
        return {VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT, 0, 0};
    case Access::transfer_read:
        return {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT, VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                VK_BUFFER_USAGE_TRANSFER_SRC_BIT};
    case Access::transfer_write:
        return {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    case Access::indirect_read:
        return {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, 0,
                VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT};
    case Access::index_read:
        return {VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, VK_ACCESS_2_INDEX_READ_BIT, 0, VK_BUFFER_USAGE_INDEX_BUFFER_BIT};
    case Access::vertex_read:
        return {VK_PIPELINE_STAGE_2_VERTEX_ATTRIBUTE_INPUT_BIT, VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT, 0,
                VK_BUFFER_USAGE_VERTEX_BUFFER_BIT};
    case Access::uniform_read:
        return {any_shader, VK_ACCESS_2_UNIFORM_READ_BIT, 0, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT};
    case Access::sampled_fragment:
        return {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                VK_IMAGE_USAGE_SAMPLED_BIT, 0};
    case Access::sampled_compute:
        return {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, VK_IMAGE_USAGE_SAMPLED_BIT,
                0};
    case Access::storage_read_vertex:
        return {VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT, storage_image,
                storage_buffer};
    case Access::storage_read_fragment:
        return {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT, storage_image,
                storage_buffer};
    case Access::storage_write_fragment:
        return {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, storage_image,
                storage_buffer};
    case Access::storage_read_write_fragment:
        return {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, storage_access, storage_image, storage_buffer};
    case Access::storage_read_compute:
        return {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT, storage_image,
                storage_buffer};
    case Access::storage_write_compute:
        return {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, storage_image,
                storage_buffer};
    case Access::storage_read_write_compute:
        return {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, storage_access, storage_image, storage_buffer};
    // A resolve belongs to the colour attachments' stage, for depth too (7.1 "Render Pass Multisample
    // Resolve").
    case Access::colour_attachment:
    case Access::resolve_attachment:
        return {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT, VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
                VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, 0};
    case Access::colour_attachment_load:
        return {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
                VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, 0};
    case Access::depth_attachment:
    case Access::depth_attachment_load:
        return {depth_stages, depth_access, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, 0};
    case Access::depth_read:
        return {depth_stages, VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT,
                VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, 0};
    case Access::count:
        break;
    }
    return {};
}

VulkanAccess to_vulkan(AccessSet set) {
    VulkanAccess all;
    set.for_each([&](Access access) {
        const VulkanAccess one = to_vulkan(access);
        all.stages |= one.stages;
        all.access |= one.access;
        all.image_usage |= one.image_usage;
        all.buffer_usage |= one.buffer_usage;
    });
    return all;
}

VkImageLayout to_vulkan(Layout layout) {
    switch (layout) {
    case Layout::undefined:
        return VK_IMAGE_LAYOUT_UNDEFINED;
    case Layout::transfer_source:
        return VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    case Layout::transfer_target:
        return VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    case Layout::read_only:
        return VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL;
    case Layout::attachment:
        return VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
    case Layout::general:
        return VK_IMAGE_LAYOUT_GENERAL;
    case Layout::present:
        return VK_IMAGE_LAYOUT_PRESENT_SRC_KHR;
    }
    return VK_IMAGE_LAYOUT_UNDEFINED;
}

VkFormat to_vulkan(Format format) {
    switch (format) {
    case Format::r8_unorm:
        return VK_FORMAT_R8_UNORM;
    case Format::rgba8_unorm:
        return VK_FORMAT_R8G8B8A8_UNORM;
    case Format::bgra8_unorm:
        return VK_FORMAT_B8G8R8A8_UNORM;
    case Format::r32_uint:
        return VK_FORMAT_R32_UINT;
    case Format::r32_float:
        return VK_FORMAT_R32_SFLOAT;
    case Format::rg16_float:
        return VK_FORMAT_R16G16_SFLOAT;
    case Format::rgba16_float:
        return VK_FORMAT_R16G16B16A16_SFLOAT;
    case Format::d32_float:
        return VK_FORMAT_D32_SFLOAT;
    }
    return VK_FORMAT_UNDEFINED;
}

} // namespace brittle::engine
