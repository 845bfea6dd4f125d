#include "engine/render/shadow_pass.h"

#include "compiled/fade_frag.h"
#include "compiled/glass_shadow_vert.h"
#include "compiled/material_cut_out_frag.h"
#include "compiled/material_shadow_vert.h"
#include "compiled/shadow_fading_vert.h"
#include "compiled/shadow_sphere_vert.h"
#include "compiled/shadow_splinter_vert.h"
#include "compiled/shadow_vert.h"
#include "engine/render/materials.h"
#include "engine/render/splinter_input.h"

namespace brittle::engine {

ShadowPass::ShadowPass(const Device& device, VkPipelineLayout layout, const SphereMesh& sphere)
    : device_(device), layout_(layout), sphere_(sphere) {
    const VkVertexInputBindingDescription binding{0, sizeof(glm::vec3), VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription attribute{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0};
    // Front faces are drawn, although back faces would need no bias: the back face of a piece that stands on the ground
    // lies in the ground, so its shadow would begin one bias away from the piece.
    pipeline_ = Pipeline(device, {.name = "shadow",
                                  .layout = layout,
                                  .vertex = shadow_vert,
                                  .bindings = {&binding, 1},
                                  .attributes = {&attribute, 1}});
    // A fading piece casts a shadow with the holes of its dither pattern.
    const FadingConstant fading;
    fading_ = Pipeline(device, {.name = "shadow of fading pieces",
                                .layout = layout,
                                .vertex = shadow_fading_vert,
                                .fragment = fade_frag,
                                .bindings = {&binding, 1},
                                .attributes = {&attribute, 1},
                                .constants = &fading.info});
    glass_ = Pipeline(device, {.name = "shadow of glass",
                               .layout = layout,
                               .vertex = glass_shadow_vert,
                               .fragment = fade_frag,
                               .bindings = {&binding, 1},
                               .attributes = {&attribute, 1},
                               .constants = &fading.info});
    spheres_ = Pipeline(device, {.name = "shadow of spheres",
                                 .layout = layout,
                                 .vertex = shadow_sphere_vert,
                                 .bindings = SphereMesh::bindings,
                                 .attributes = SphereMesh::attributes});
    splinters_ = Pipeline(device, {.name = "shadow of splinters",
                                   .layout = layout,
                                   .vertex = shadow_splinter_vert,
                                   .bindings = splinter_bindings,
                                   .attributes = splinter_attributes});
}

void ShadowPass::make_material_pipelines() {
    if (materials_.cut_out.handle()) return;
    const auto make = [this](const char* name, bool fading) {
        const CutOutConstants constants(fading);
        return Pipeline(device_, {.name = name,
                                  .layout = layout_,
                                  .vertex = material_shadow_vert,
                                  .fragment = material_cut_out_frag,
                                  .bindings = material_bindings,
                                  .attributes = material_attributes,
                                  .constants = &constants.info});
    };
    materials_.fading = make("shadow of fading pieces with materials", true);
    materials_.cut_out = make("shadow of materials cut out", false);
}

void ShadowPass::declare(Frame& frame) {
    frame.stats.shadow_drawn = true;
    const bool cut_out = frame.draws_pieces() && frame.materials && frame.materials->has_cut_outs();
    if (cut_out) make_material_pipelines();
    const bool spheres = frame.scene.spheres_cast_shadows && frame.spheres.valid();
    const Buffer sphere = spheres ? sphere_.import(frame) : Buffer{};
    frame.graph.add_pass(
        "shadow", PassKind::graphics,
        [&](PassBuilder& pass) {
            if (frame.draws_pieces()) read_pieces(frame, pass, frame.light_commands);
            if (cut_out) read_materials(frame, pass);
            if (spheres) {
                pass.read(sphere, Access::vertex_read);
                pass.read(frame.spheres, Access::vertex_read);
            }
            if (frame.splinters.valid()) pass.read(frame.splinters, Access::vertex_read);
            if (frame.draws_pieces() || frame.splinters.valid() || spheres)
                pass.read(frame.uniforms, Access::uniform_read);
            frame.shadow = pass.write(frame.shadow, Access::depth_attachment);
        },
        [this, &frame, cut_out, spheres, sphere](PassContext& context) {
            begin_rendering(context.commands, {.extent = context.extent(frame.shadow),
                                               .depth = context.view(frame.shadow),
                                               .depth_load = VK_ATTACHMENT_LOAD_OP_CLEAR});
            if (cut_out) bind_materials(frame, context);
            if (frame.draws_pieces())
                draw_pieces(frame, context, frame.light_commands,
                            cut_out ? PiecePipelines{materials_.cut_out, &materials_.fading}
                                    : PiecePipelines{pipeline_, &fading_});
            if (frame.draws_glass()) draw_pieces(frame, context, frame.light_commands, {glass_, &glass_});
            if (frame.splinters.valid()) draw_splinters(frame, context, splinters_);
            if (spheres) sphere_.draw(context, spheres_, sphere, frame);
            vkCmdEndRendering(context.commands);
        });
}

} // namespace brittle::engine
