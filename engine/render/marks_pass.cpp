#include "engine/render/marks_pass.h"

#include "compiled/line_frag.h"
#include "compiled/line_vert.h"
#include "compiled/sphere_frag.h"
#include "compiled/sphere_vert.h"

namespace brittle::engine {

MarksPass::MarksPass(const Device& device, VkPipelineLayout layout, const TargetFormat& target,
                     const SphereMesh& sphere)
    : sphere_(sphere), samples_(target.samples) {
    spheres_ = Pipeline(device, {.name = "spheres",
                                 .layout = layout,
                                 .vertex = sphere_vert,
                                 .fragment = sphere_frag,
                                 .bindings = SphereMesh::bindings,
                                 .attributes = SphereMesh::attributes,
                                 .colour = target.colour,
                                 .samples = target.samples});

    const VkVertexInputBindingDescription line_binding{0, sizeof(LineVertex), VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription line_attributes[] = {
        {0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(LineVertex, position)},
        {1, 0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(LineVertex, colour)}};
    lines_ = Pipeline(device, {.name = "lines",
                               .layout = layout,
                               .vertex = line_vert,
                               .fragment = line_frag,
                               .bindings = {&line_binding, 1},
                               .attributes = line_attributes,
                               .topology = VK_PRIMITIVE_TOPOLOGY_LINE_LIST,
                               .cull = VK_CULL_MODE_NONE,
                               .colour = target.colour,
                               .samples = target.samples});
}

void MarksPass::declare(Frame& frame, VkExtent2D extent) const {
    const Scene& scene = frame.scene;
    const bool lines = frame.lines.valid(), spheres = frame.spheres.valid();
    const Marks hidden{lines && !scene.lines_on_top, spheres && !scene.spheres_on_top};
    const Marks on_top{lines && scene.lines_on_top, spheres && scene.spheres_on_top};
    const bool any_on_top = on_top.lines || on_top.spheres;
    if (hidden.lines || hidden.spheres)
        frame.depth = declare(frame, "marks", hidden, frame.depth, VK_ATTACHMENT_LOAD_OP_LOAD, !any_on_top);
    if (!any_on_top) return;
    // Marks on top hide each other and nothing else.
    const Image depth = frame.graph.create_image(
        "depth of marks on top",
        {.width = extent.width, .height = extent.height, .format = Format::d32_float, .samples = samples_});
    (void)declare(frame, "marks on top", on_top, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, true);
}

Image MarksPass::declare(Frame& frame, const char* name, Marks marks, Image depth, VkAttachmentLoadOp depth_load,
                         bool last) const {
    const Buffer sphere = sphere_.import(frame);
    const bool clears = depth_load == VK_ATTACHMENT_LOAD_OP_CLEAR;
    frame.graph.add_pass(
        name, PassKind::graphics,
        [&](PassBuilder& pass) {
            pass.read(frame.uniforms, Access::uniform_read);
            if (marks.lines) pass.read(frame.lines, Access::vertex_read);
            if (marks.spheres) {
                pass.read(sphere, Access::vertex_read);
                pass.read(frame.spheres, Access::vertex_read);
            }
            frame.write_colour(pass, Access::colour_attachment_load, last);
            depth = pass.write(depth, clears ? Access::depth_attachment : Access::depth_attachment_load);
        },
        [this, &frame, marks, depth, depth_load, last, sphere](PassContext& context) {
            const VkCommandBuffer commands = context.commands;
            Rendering rendering = frame.colour_rendering(context, VK_ATTACHMENT_LOAD_OP_LOAD, last);
            rendering.depth = context.view(depth);
            rendering.depth_load = depth_load;
            begin_rendering(commands, rendering);
            if (marks.spheres) sphere_.draw(context, spheres_, sphere, frame);
            if (marks.lines) {
                const VkBuffer buffer = context.buffer(frame.lines);
                const VkDeviceSize start = 0;
                vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, lines_.handle());
                vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &start);
                vkCmdDraw(commands, static_cast<uint32_t>(frame.scene.lines.size()), 1, 0, 0);
            }
            vkCmdEndRendering(commands);
        });
    return depth;
}

} // namespace brittle::engine
