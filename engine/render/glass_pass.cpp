#include "engine/render/glass_pass.h"

#include <cmath>

#include "compiled/background_vert.h"
#include "compiled/glass_composite_frag.h"
#include "compiled/glass_frag.h"
#include "compiled/glass_samples_frag.h"
#include "compiled/glass_vert.h"
#include "engine/render/material_input.h"
#include "engine/render/materials.h"

namespace brittle::engine {

namespace {

constexpr VkFormat sums_format = VK_FORMAT_R16G16B16A16_SFLOAT;
// As in glass_composite.frag: the share of the height by which two faces move what is behind them.
constexpr float max_bend = 2.0f * 0.02f;

} // namespace

int32_t glass_margin(uint32_t height) {
    return static_cast<int32_t>(std::ceil(max_bend * static_cast<float>(height))) + 1;
}

GlassPass::GlassPass(const Device& device, VkPipelineLayout layout, const TargetFormat& target, const Quality& quality)
    : samples_(target.samples) {
    const VkSpecializationMapEntry entries[] = {{shared::constant_soft_shadows, 0, sizeof(VkBool32)},
                                                {shared::constant_fading, sizeof(VkBool32), sizeof(VkBool32)}};
    const auto faces = [&](const char* name, VkBool32 fading) {
        const VkBool32 values[] = {*quality.soft_shadows, fading};
        const VkSpecializationInfo constants{2, entries, sizeof values, values};
        return Pipeline(device, {.name = name,
                                 .layout = layout,
                                 .vertex = glass_vert,
                                 .fragment = target.samples > 1 ? std::span<const uint32_t>(glass_samples_frag)
                                                                : std::span<const uint32_t>(glass_frag),
                                 .bindings = material_bindings,
                                 .attributes = material_attributes,
                                 .cull = VK_CULL_MODE_NONE,
                                 .depth = false,
                                 .colour = sums_format,
                                 .blend = Blend::add,
                                 .samples = target.samples,
                                 .constants = &constants});
    };
    faces_ = faces("faces of glass", VK_FALSE);
    fading_faces_ = faces("faces of fading glass", VK_TRUE);
    composite_ = Pipeline(device, {.name = "glass over the picture",
                                   .layout = layout,
                                   .vertex = background_vert,
                                   .fragment = glass_composite_frag,
                                   .cull = VK_CULL_MODE_NONE,
                                   .depth = false,
                                   .colour = target.colour});
}

Image GlassPass::declare(Frame& frame, Image result, VkExtent2D extent) const {
    ImageDesc desc{.width = extent.width, .height = extent.height, .format = Format::rgba16_float};
    Image sums = frame.graph.create_image("glass", desc);
    desc.samples = samples_;
    Image of_samples = samples_ > 1 ? frame.graph.create_image("samples of glass", desc) : Image{};
    frame.graph.add_pass(
        "glass", PassKind::graphics,
        [&](PassBuilder& pass) {
            read_pieces(frame, pass, frame.camera_commands);
            read_materials(frame, pass);
            pass.read(frame.uniforms, Access::uniform_read);
            pass.read(frame.shadow, Access::sampled_fragment);
            pass.read(frame.depth, Access::sampled_fragment);
            if (of_samples.valid()) {
                of_samples = pass.write(of_samples, Access::colour_attachment);
                sums = pass.write(sums, Access::resolve_attachment);
            } else {
                sums = pass.write(sums, Access::colour_attachment);
            }
        },
        [this, &frame, sums, of_samples](PassContext& context) {
            const bool resolves = of_samples.valid();
            begin_rendering(context.commands, {.extent = context.extent(sums),
                                               .colour = context.view(resolves ? of_samples : sums),
                                               .colour_load = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                               .resolve = resolves ? context.view(sums) : VK_NULL_HANDLE,
                                               .scissor = frame.scissor});
            frame.bind_image(context, frame.depth_behind_set, frame.depth);
            bind_materials(frame, context);
            draw_pieces(frame, context, frame.camera_commands, {faces_, &fading_faces_});
            vkCmdEndRendering(context.commands);
        });

    const Image behind = frame.colour;
    frame.graph.add_pass(
        "glass over the picture", PassKind::graphics,
        [&](PassBuilder& pass) {
            pass.read(frame.uniforms, Access::uniform_read);
            pass.read(behind, Access::sampled_fragment);
            pass.read(sums, Access::sampled_fragment);
            result = pass.write(result, Access::colour_attachment);
        },
        [this, &frame, behind, sums, result](PassContext& context) {
            begin_rendering(context.commands, {.extent = context.extent(result),
                                               .colour = context.view(result),
                                               .colour_load = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                               .scissor = frame.scissor});
            vkCmdBindPipeline(context.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, composite_.handle());
            frame.bind_image(context, frame.behind_glass_set, behind);
            frame.bind_image(context, frame.glass_set, sums, 3);
            vkCmdDraw(context.commands, 3, 1, 0, 0);
            vkCmdEndRendering(context.commands);
        });
    return result;
}

} // namespace brittle::engine
