#include "engine/render/id_pass.h"

#include "compiled/piece_id_frag.h"
#include "compiled/piece_id_vert.h"

namespace brittle::engine {

IdPass::IdPass(const Device& device, VkPipelineLayout layout) {
    const VkVertexInputBindingDescription binding{0, sizeof(glm::vec3), VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription attribute{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0};
    PipelineDesc desc{.name = "ids of pieces",
                      .layout = layout,
                      .vertex = piece_id_vert,
                      .fragment = piece_id_frag,
                      .bindings = {&binding, 1},
                      .attributes = {&attribute, 1},
                      .depth_test = piece_depth_test,
                      .colour = VK_FORMAT_R32_UINT};
    pipeline_ = Pipeline(device, desc);
    const FadingConstant fading;
    desc.name = "ids of fading pieces";
    desc.constants = &fading.info;
    fading_ = Pipeline(device, desc);
}

Image IdPass::declare(Frame& frame, VkExtent2D extent) const {
    ImageDesc desc{.width = extent.width, .height = extent.height, .format = Format::r32_uint};
    Image ids = frame.graph.create_image("ids", desc);
    desc.format = Format::d32_float;
    Image depth = frame.graph.create_image("depth of ids", desc);
    frame.graph.add_pass(
        "ids", PassKind::graphics,
        [&](PassBuilder& pass) {
            if (frame.draws_pieces()) read_pieces(frame, pass, frame.camera_commands);
            pass.read(frame.uniforms, Access::uniform_read);
            ids = pass.write(ids, Access::colour_attachment);
            depth = pass.write(depth, Access::depth_attachment);
        },
        [this, &frame, ids, depth](PassContext& context) {
            begin_rendering(context.commands, {.extent = context.extent(ids),
                                               .colour = context.view(ids),
                                               .colour_load = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                               .depth = context.view(depth),
                                               .depth_load = VK_ATTACHMENT_LOAD_OP_CLEAR});
            if (frame.draws_pieces()) draw_pieces(frame, context, frame.camera_commands, {pipeline_, &fading_});
            vkCmdEndRendering(context.commands);
        });
    return ids;
}

} // namespace brittle::engine
