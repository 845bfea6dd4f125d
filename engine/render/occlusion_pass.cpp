#include "engine/render/occlusion_pass.h"

#include "compiled/background_vert.h"
#include "compiled/fade_frag.h"
#include "compiled/ground_vert.h"
#include "compiled/occlusion_frag.h"
#include "compiled/piece_vert.h"

namespace brittle::engine {

OcclusionPass::OcclusionPass(const Device& device, VkPipelineLayout layout) {
    const VkVertexInputBindingDescription binding{0, sizeof(glm::vec3), VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription attribute{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0};
    pieces_ = Pipeline(device, {.name = "depth of pieces",
                                .layout = layout,
                                .vertex = piece_vert,
                                .bindings = {&binding, 1},
                                .attributes = {&attribute, 1}});
    const FadingConstant fading;
    fading_ = Pipeline(device, {.name = "depth of fading pieces",
                                .layout = layout,
                                .vertex = piece_vert,
                                .fragment = fade_frag,
                                .bindings = {&binding, 1},
                                .attributes = {&attribute, 1},
                                .constants = &fading.info});
    ground_ = Pipeline(device, {.name = "depth of the ground", .layout = layout, .vertex = ground_vert});
    occlusion_ = Pipeline(device, {.name = "occlusion",
                                   .layout = layout,
                                   .vertex = background_vert,
                                   .fragment = occlusion_frag,
                                   .cull = VK_CULL_MODE_NONE,
                                   .depth = false,
                                   .colour = VK_FORMAT_R16G16_SFLOAT});
}

void OcclusionPass::declare(Frame& frame, VkExtent2D extent) const {
    ImageDesc desc{.width = extent.width, .height = extent.height, .format = Format::d32_float};
    Image depth = frame.graph.create_image("depth before shading", desc);
    frame.graph.add_pass(
        "depth", PassKind::graphics,
        [&](PassBuilder& pass) {
            if (frame.draws_pieces()) read_pieces(frame, pass, frame.camera_commands);
            pass.read(frame.uniforms, Access::uniform_read);
            depth = pass.write(depth, Access::depth_attachment);
        },
        [this, &frame, depth](PassContext& context) {
            const VkCommandBuffer commands = context.commands;
            begin_rendering(commands, {.extent = context.extent(depth),
                                       .depth = context.view(depth),
                                       .depth_load = VK_ATTACHMENT_LOAD_OP_CLEAR});
            if (frame.draws_pieces()) draw_pieces(frame, context, frame.camera_commands, {pieces_, &fading_});
            if (frame.scene.ground) {
                vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, ground_.handle());
                vkCmdDraw(commands, 6, 1, 0, 0);
            }
            vkCmdEndRendering(commands);
        });

    desc.format = Format::rg16_float;
    frame.occlusion = frame.graph.create_image("occlusion", desc);
    frame.graph.add_pass(
        "occlusion", PassKind::graphics,
        [&](PassBuilder& pass) {
            pass.read(frame.uniforms, Access::uniform_read);
            pass.read(depth, Access::sampled_fragment);
            frame.occlusion = pass.write(frame.occlusion, Access::colour_attachment);
        },
        [this, &frame, depth](PassContext& context) {
            const VkCommandBuffer commands = context.commands;
            begin_rendering(commands, {.extent = context.extent(frame.occlusion),
                                       .colour = context.view(frame.occlusion),
                                       .colour_load = VK_ATTACHMENT_LOAD_OP_DONT_CARE});
            vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, occlusion_.handle());
            frame.bind_image(context, frame.depth_set, depth);
            vkCmdDraw(commands, 3, 1, 0, 0);
            vkCmdEndRendering(commands);
        });
}

} // namespace brittle::engine
