#include "engine/render/marks_pass.h"

#include <array>
#include <vector>

#include <glm/geometric.hpp>

#include "compiled/line_frag.h"
#include "compiled/line_vert.h"
#include "compiled/sphere_frag.h"
#include "compiled/sphere_vert.h"
#include "engine/graph/upload.h"

namespace brittle::engine {

namespace {

using Corners = std::array<glm::vec3, 3>;

// An octahedron whose faces are split in four, twice: 128 triangles, round enough for a mark of a few pixels.
std::vector<glm::vec3> unit_sphere() {
    std::vector<Corners> faces;
    for (int octant = 0; octant < 8; ++octant) {
        const glm::vec3 x(octant & 1 ? -1.0f : 1.0f, 0.0f, 0.0f), y(0.0f, octant & 2 ? -1.0f : 1.0f, 0.0f),
            z(0.0f, 0.0f, octant & 4 ? -1.0f : 1.0f);
        const bool mirrored = ((octant & 1) + (octant >> 1 & 1) + (octant >> 2)) % 2 != 0;
        faces.push_back(mirrored ? Corners{x, z, y} : Corners{x, y, z});
    }
    for (int level = 0; level < 2; ++level) {
        std::vector<Corners> finer;
        for (const auto& [a, b, c] : faces) {
            const glm::vec3 ab = glm::normalize(a + b), bc = glm::normalize(b + c),
                            ca = glm::normalize(c + a);
            finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        faces = std::move(finer);
    }
    std::vector<glm::vec3> vertices;
    for (const Corners& face : faces) vertices.insert(vertices.end(), face.begin(), face.end());
    return vertices;
}

} // namespace

MarksPass::MarksPass(const Device& device, VkPipelineLayout layout, const TargetFormat& target) {
    const VkVertexInputBindingDescription sphere_bindings[] = {
        {0, sizeof(glm::vec3), VK_VERTEX_INPUT_RATE_VERTEX},
        {1, sizeof(Sphere), VK_VERTEX_INPUT_RATE_INSTANCE}};
    const VkVertexInputAttributeDescription sphere_attributes[] = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0},
                                                                   {1, 1, VK_FORMAT_R32G32B32A32_SFLOAT, 0}};
    spheres_ = Pipeline(device, {.name = "spheres",
                                 .layout = layout,
                                 .vertex = sphere_vert,
                                 .fragment = sphere_frag,
                                 .bindings = sphere_bindings,
                                 .attributes = sphere_attributes,
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

    const std::vector<glm::vec3> vertices = unit_sphere();
    sphere_vertex_count_ = static_cast<uint32_t>(vertices.size());
    const auto bytes = std::as_bytes(std::span(vertices));
    sphere_vertices_ = DeviceBuffer(device, "sphere", bytes.size(),
                                    VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                    MemoryKind::device);
    const Upload uploads[] = {{&sphere_vertices_, bytes, Access::vertex_read}};
    upload(device, uploads);
}

void MarksPass::declare(Frame& frame) const {
    const Scene& scene = frame.scene;
    const bool lines = frame.lines.valid(), spheres = frame.spheres.valid();
    const Marks hidden{lines && !scene.lines_on_top, spheres && !scene.spheres_on_top};
    const Marks on_top{lines && scene.lines_on_top, spheres && scene.spheres_on_top};
    const bool any_on_top = on_top.lines || on_top.spheres;
    if (hidden.lines || hidden.spheres)
        declare(frame, "marks", hidden, VK_ATTACHMENT_LOAD_OP_LOAD, !any_on_top);
    // Among themselves, marks on top hide each other as usual, in a depth buffer of their own.
    if (any_on_top) declare(frame, "marks on top", on_top, VK_ATTACHMENT_LOAD_OP_CLEAR, true);
}

void MarksPass::declare(Frame& frame, const char* name, Marks marks, VkAttachmentLoadOp depth_load,
                        bool last) const {
    const Buffer sphere =
        frame.graph.import_buffer("sphere", {sphere_vertices_.size()},
                                  {.initial = Access::vertex_read,
                                   .final = {},
                                   .external = frame.external.add(sphere_vertices_.handle())});
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
            frame.depth =
                pass.write(frame.depth, clears ? Access::depth_attachment : Access::depth_attachment_load);
        },
        [this, &frame, marks, depth_load, last, sphere](PassContext& context) {
            const VkCommandBuffer commands = context.commands;
            Rendering rendering = frame.colour_rendering(context, VK_ATTACHMENT_LOAD_OP_LOAD, last);
            rendering.depth_load = depth_load;
            begin_rendering(commands, rendering);
            if (marks.spheres) {
                const VkBuffer buffers[] = {context.buffer(sphere), context.buffer(frame.spheres)};
                const VkDeviceSize starts[] = {0, 0};
                vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, spheres_.handle());
                vkCmdBindVertexBuffers(commands, 0, 2, buffers, starts);
                vkCmdDraw(commands, sphere_vertex_count_, static_cast<uint32_t>(frame.scene.spheres.size()),
                          0, 0);
            }
            if (marks.lines) {
                const VkBuffer buffer = context.buffer(frame.lines);
                const VkDeviceSize start = 0;
                vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, lines_.handle());
                vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &start);
                vkCmdDraw(commands, static_cast<uint32_t>(frame.scene.lines.size()), 1, 0, 0);
            }
            vkCmdEndRendering(commands);
        });
}

} // namespace brittle::engine
