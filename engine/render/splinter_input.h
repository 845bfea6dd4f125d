// The vertex input of pipelines that draw Scene::splinters (shaders/splinter.glsl): one instance for each splinter, whose
// mesh the shader holds.
//
//     pass.read(frame.splinters, Access::vertex_read);   // in a pass's declaration
//     draw_splinters(frame, context, pipeline);          // in its execute function
#pragma once

#include <cstddef>

#include <vulkan/vulkan.h>

#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"
#include "engine/render/scene.h"
#include "shaders/shared.h"

namespace brittle::engine {

inline constexpr VkVertexInputBindingDescription splinter_bindings[] = {
    {0, sizeof(Splinter), VK_VERTEX_INPUT_RATE_INSTANCE}};
inline constexpr VkVertexInputAttributeDescription splinter_attributes[] = {
    {0, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Splinter, rotation)},
    {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Splinter, centre)},
    {2, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Splinter, colour)}};

// Records one draw of all splinters of the scene, which must have at least one.
inline void draw_splinters(const Frame& frame, const PassContext& context, const Pipeline& pipeline) {
    const VkBuffer buffer = context.buffer(frame.splinters);
    const VkDeviceSize start = 0;
    vkCmdBindPipeline(context.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.handle());
    vkCmdBindVertexBuffers(context.commands, 0, 1, &buffer, &start);
    vkCmdDraw(context.commands, shared::splinter_vertices, static_cast<uint32_t>(frame.scene.splinters.size()), 0, 0);
}

} // namespace brittle::engine
