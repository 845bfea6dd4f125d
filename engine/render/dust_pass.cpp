#include "engine/render/dust_pass.h"

#include <cstddef>

#include "compiled/dust_frag.h"
#include "compiled/dust_samples_frag.h"
#include "compiled/dust_vert.h"

namespace brittle::engine {

DustPass::DustPass(const Device& device, VkPipelineLayout layout, const TargetFormat& target) {
    const VkVertexInputBindingDescription binding{0, sizeof(DustPuff), VK_VERTEX_INPUT_RATE_INSTANCE};
    const VkVertexInputAttributeDescription attributes[] = {
        {0, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(DustPuff, centre)},
        {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(DustPuff, colour)},
        {2, 0, VK_FORMAT_R32_UINT, offsetof(DustPuff, pattern)}};
    puffs_ = Pipeline(device, {.name = "dust",
                               .layout = layout,
                               .vertex = dust_vert,
                               .fragment = target.samples > 1 ? std::span<const uint32_t>(dust_samples_frag)
                                                              : std::span<const uint32_t>(dust_frag),
                               .bindings = {&binding, 1},
                               .attributes = attributes,
                               .cull = VK_CULL_MODE_NONE,
                               .depth = false,
                               .colour = target.colour,
                               .blend = Blend::over});
}

Image DustPass::declare(Frame& frame, Image picture) const {
    frame.graph.add_pass(
        "dust", PassKind::graphics,
        [&](PassBuilder& pass) {
            pass.read(frame.uniforms, Access::uniform_read);
            pass.read(frame.dust, Access::vertex_read);
            pass.read(frame.shadow, Access::sampled_fragment);
            pass.read(frame.depth, Access::sampled_fragment);
            picture = pass.write(picture, Access::colour_attachment_load);
        },
        [this, &frame, picture](PassContext& context) {
            begin_rendering(
                context.commands,
                {.extent = context.extent(picture), .colour = context.view(picture), .scissor = frame.scissor});
            frame.bind_image(context, frame.dust_set, frame.depth);
            const VkBuffer buffer = context.buffer(frame.dust);
            const VkDeviceSize start = 0;
            vkCmdBindPipeline(context.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, puffs_.handle());
            vkCmdBindVertexBuffers(context.commands, 0, 1, &buffer, &start);
            vkCmdDraw(context.commands, shared::puff_vertices, static_cast<uint32_t>(frame.scene.dust.size()), 0, 0);
            vkCmdEndRendering(context.commands);
        });
    return picture;
}

} // namespace brittle::engine
