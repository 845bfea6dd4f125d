#include "engine/render/id_pass.h"

#include "compiled/material_id_frag.h"
#include "compiled/material_id_vert.h"
#include "compiled/piece_id_frag.h"
#include "compiled/piece_id_vert.h"
#include "engine/render/materials.h"

namespace brittle::engine {

IdPass::IdPass(const Device& device, VkPipelineLayout layout) : device_(device), layout_(layout) {
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

void IdPass::make_material_pipelines() {
    if (materials_.cut_out.handle()) return;
    const auto make = [this](const char* name, bool fading) {
        const CutOutConstants constants(fading);
        return Pipeline(device_, {.name = name,
                                  .layout = layout_,
                                  .vertex = material_id_vert,
                                  .fragment = material_id_frag,
                                  .bindings = material_bindings,
                                  .attributes = material_attributes,
                                  .depth_test = piece_depth_test,
                                  .colour = VK_FORMAT_R32_UINT,
                                  .constants = &constants.info});
    };
    materials_.fading = make("ids of fading pieces with materials", true);
    materials_.cut_out = make("ids of materials cut out", false);
}

Image IdPass::declare(Frame& frame, VkExtent2D extent) {
    const bool cut_out = frame.draws_pieces() && frame.materials && frame.materials->has_cut_outs();
    if (cut_out) make_material_pipelines();
    ImageDesc desc{.width = extent.width, .height = extent.height, .format = Format::r32_uint};
    Image ids = frame.graph.create_image("ids", desc);
    desc.format = Format::d32_float;
    Image depth = frame.graph.create_image("depth of ids", desc);
    frame.graph.add_pass(
        "ids", PassKind::graphics,
        [&](PassBuilder& pass) {
            if (frame.draws_pieces()) read_pieces(frame, pass, frame.camera_commands);
            if (cut_out) read_materials(frame, pass);
            pass.read(frame.uniforms, Access::uniform_read);
            ids = pass.write(ids, Access::colour_attachment);
            depth = pass.write(depth, Access::depth_attachment);
        },
        [this, &frame, cut_out, ids, depth](PassContext& context) {
            begin_rendering(context.commands, {.extent = context.extent(ids),
                                               .colour = context.view(ids),
                                               .colour_load = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                               .depth = context.view(depth),
                                               .depth_load = VK_ATTACHMENT_LOAD_OP_CLEAR});
            if (cut_out) bind_materials(frame, context);
            if (frame.draws_pieces())
                draw_pieces(frame, context, frame.camera_commands,
                            cut_out ? PiecePipelines{materials_.cut_out, &materials_.fading}
                                    : PiecePipelines{pipeline_, &fading_});
            vkCmdEndRendering(context.commands);
        });
    return ids;
}

} // namespace brittle::engine
