#include "engine/render/shade_pass.h"

#include "compiled/background_frag.h"
#include "compiled/background_vert.h"
#include "compiled/ground_frag.h"
#include "compiled/ground_vert.h"
#include "compiled/line_frag.h"
#include "compiled/material_piece_frag.h"
#include "compiled/material_piece_vert.h"
#include "compiled/piece_edges_vert.h"
#include "compiled/piece_frag.h"
#include "compiled/piece_smooth_frag.h"
#include "compiled/piece_smooth_vert.h"
#include "compiled/piece_vert.h"
#include "compiled/splinter_vert.h"
#include "engine/gpu/device.h"
#include "engine/render/materials.h"
#include "engine/render/splinter_input.h"

namespace brittle::engine {

ShadePass::ShadePass(const Device& device, VkPipelineLayout layout, const TargetFormat& target, const Quality& quality)
    : device_(device), layout_(layout), target_(target), soft_shadows_(*quality.soft_shadows),
      ambient_occlusion_(*quality.ambient_occlusion) {
    const VkSpecializationMapEntry entries[] = {
        {shared::constant_soft_shadows, 0, sizeof(VkBool32)},
        {shared::constant_ambient_occlusion, sizeof(VkBool32), sizeof(VkBool32)},
        {shared::constant_fading, 2 * sizeof(VkBool32), sizeof(VkBool32)}};
    const VkBool32 values[] = {*quality.soft_shadows, *quality.ambient_occlusion, VK_FALSE};
    const VkBool32 fading_values[] = {values[0], values[1], VK_TRUE};
    const VkSpecializationInfo constants{3, entries, sizeof values, values};
    const VkSpecializationInfo fading{3, entries, sizeof values, fading_values};

    const VkVertexInputBindingDescription binding{0, sizeof(glm::vec3), VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription attribute{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0};
    PipelineDesc desc{.name = "pieces",
                      .layout = layout,
                      .vertex = piece_vert,
                      .fragment = piece_frag,
                      .bindings = {&binding, 1},
                      .attributes = {&attribute, 1},
                      .depth_test = piece_depth_test,
                      .colour = target.colour,
                      .samples = target.samples,
                      .constants = &constants};
    splinters_ = Pipeline(device, {.name = "splinters",
                                   .layout = layout,
                                   .vertex = splinter_vert,
                                   .fragment = piece_frag,
                                   .bindings = splinter_bindings,
                                   .attributes = splinter_attributes,
                                   .colour = target.colour,
                                   .samples = target.samples,
                                   .constants = &constants});
    // Fading pieces have their own pipelines, because a fragment shader with discard loses the early depth test.
    PipelineDesc fading_desc = desc;
    fading_desc.name = "fading pieces";
    fading_desc.constants = &fading;
    pieces_ = Pipeline(device, desc);
    fading_pieces_ = Pipeline(device, fading_desc);
    const VkVertexInputBindingDescription smooth_bindings[] = {binding,
                                                               {1, sizeof(glm::vec3), VK_VERTEX_INPUT_RATE_VERTEX}};
    const VkVertexInputAttributeDescription smooth_attributes[] = {attribute, {1, 1, VK_FORMAT_R32G32B32_SFLOAT, 0}};
    for (PipelineDesc* of : {&desc, &fading_desc}) {
        of->vertex = piece_smooth_vert;
        of->fragment = piece_smooth_frag;
        of->bindings = smooth_bindings;
        of->attributes = smooth_attributes;
    }
    desc.name = "smooth pieces";
    fading_desc.name = "smooth fading pieces";
    smooth_pieces_ = Pipeline(device, desc);
    fading_smooth_pieces_ = Pipeline(device, fading_desc);
    if (device.has_line_mode())
        edges_ = Pipeline(device, {.name = "edges of pieces",
                                   .layout = layout,
                                   .vertex = piece_edges_vert,
                                   .fragment = line_frag,
                                   .bindings = {&binding, 1},
                                   .attributes = {&attribute, 1},
                                   .fill = VK_POLYGON_MODE_LINE,
                                   .colour = target.colour,
                                   .samples = target.samples});
    // Back faces of the ground are culled, so that a camera below it sees the pieces.
    ground_ = Pipeline(device, {.name = "ground",
                                .layout = layout,
                                .vertex = ground_vert,
                                .fragment = ground_frag,
                                .colour = target.colour,
                                .samples = target.samples,
                                .constants = &constants});
    background_ = Pipeline(device, {.name = "background",
                                    .layout = layout,
                                    .vertex = background_vert,
                                    .fragment = background_frag,
                                    .cull = VK_CULL_MODE_NONE,
                                    .depth_write = false,
                                    .colour = target.colour,
                                    .samples = target.samples,
                                    .constants = &constants});
}

void ShadePass::make_material_pipelines() {
    if (materials_.solid.handle()) return;
    const VkSpecializationMapEntry entries[] = {
        {shared::constant_soft_shadows, 0, sizeof(VkBool32)},
        {shared::constant_ambient_occlusion, sizeof(VkBool32), sizeof(VkBool32)},
        {shared::constant_fading, 2 * sizeof(VkBool32), sizeof(VkBool32)},
        {shared::constant_cut_out, 3 * sizeof(VkBool32), sizeof(VkBool32)}};
    const auto make = [&](const char* name, bool fading, bool cut_out) {
        const VkBool32 values[] = {soft_shadows_, ambient_occlusion_, fading, cut_out};
        const VkSpecializationInfo constants{4, entries, sizeof values, values};
        return Pipeline(device_, {.name = name,
                                  .layout = layout_,
                                  .vertex = material_piece_vert,
                                  .fragment = material_piece_frag,
                                  .bindings = material_bindings,
                                  .attributes = material_attributes,
                                  .depth_test = piece_depth_test,
                                  .colour = target_.colour,
                                  .samples = target_.samples,
                                  .constants = &constants});
    };
    materials_.fading = make("fading pieces with materials", true, true);
    materials_.cut_out = make("pieces with materials cut out", false, true);
    materials_.solid = make("pieces with materials", false, false);
}

void ShadePass::draw_all_pieces(Frame& frame, const PassContext& context) const {
    const VkCommandBuffer commands = context.commands;
    if (frame.materials) {
        bind_materials(frame, context);
        const bool cut_out = frame.materials->has_cut_outs();
        draw_pieces(frame, context, frame.camera_commands,
                    {cut_out ? materials_.cut_out : materials_.solid, &materials_.fading});
    } else {
        const bool smooth = frame.scene.smooth;
        if (smooth) {
            const VkBuffer normals = context.buffer(frame.normals);
            const VkDeviceSize start = 0;
            vkCmdBindVertexBuffers(commands, 1, 1, &normals, &start);
        }
        draw_pieces(frame, context, frame.camera_commands,
                    smooth ? PiecePipelines{smooth_pieces_, &fading_smooth_pieces_}
                           : PiecePipelines{pieces_, &fading_pieces_});
    }
    if (frame.scene.wireframe && edges_.handle()) draw_pieces(frame, context, frame.camera_commands, {edges_});
}

void ShadePass::declare(Frame& frame) {
    if (frame.draws_pieces() && frame.materials) make_material_pipelines();
    frame.graph.add_pass(
        "shade", PassKind::graphics,
        [&](PassBuilder& pass) {
            if (frame.draws_pieces()) read_pieces(frame, pass, frame.camera_commands);
            if (frame.draws_pieces() && frame.materials)
                read_materials(frame, pass);
            else if (frame.draws_pieces() && frame.scene.smooth)
                pass.read(frame.normals, Access::vertex_read);
            if (frame.splinters.valid()) pass.read(frame.splinters, Access::vertex_read);
            pass.read(frame.uniforms, Access::uniform_read);
            pass.read(frame.shadow, Access::sampled_fragment);
            if (frame.occlusion.valid()) pass.read(frame.occlusion, Access::sampled_fragment);
            frame.write_colour(pass, Access::colour_attachment, !frame.draws_marks());
            frame.depth = pass.write(frame.depth, Access::depth_attachment);
        },
        [this, &frame](PassContext& context) {
            const VkCommandBuffer commands = context.commands;
            // No clear is needed: the background covers every pixel without piece or ground.
            Rendering rendering =
                frame.colour_rendering(context, VK_ATTACHMENT_LOAD_OP_DONT_CARE, !frame.draws_marks());
            rendering.depth_load = VK_ATTACHMENT_LOAD_OP_CLEAR;
            begin_rendering(commands, rendering);
            // The shaders declare an image in set 1, so one must be bound. Without occlusion they do not read it.
            frame.bind_image(context, frame.occlusion_set, frame.occlusion.valid() ? frame.occlusion : frame.shadow);
            if (frame.draws_pieces()) draw_all_pieces(frame, context);
            if (frame.splinters.valid()) draw_splinters(frame, context, splinters_);
            if (frame.scene.ground) {
                vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, ground_.handle());
                vkCmdDraw(commands, 6, 1, 0, 0);
            }
            vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, background_.handle());
            vkCmdDraw(commands, 3, 1, 0, 0);
            vkCmdEndRendering(commands);
        });
}

} // namespace brittle::engine
