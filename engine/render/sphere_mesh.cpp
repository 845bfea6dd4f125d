#include "engine/render/sphere_mesh.h"

#include <span>
#include <vector>

#include <glm/geometric.hpp>

#include "engine/graph/upload.h"

namespace brittle::engine {

namespace {

using Corners = std::array<glm::vec3, 3>;

// Returns an octahedron whose faces are split in four, twice: 128 triangles, enough for a sphere of a few pixels.
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
            const glm::vec3 ab = glm::normalize(a + b), bc = glm::normalize(b + c), ca = glm::normalize(c + a);
            finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        faces = std::move(finer);
    }
    std::vector<glm::vec3> vertices;
    for (const Corners& face : faces) vertices.insert(vertices.end(), face.begin(), face.end());
    return vertices;
}

} // namespace

SphereMesh::SphereMesh(const Device& device) {
    const std::vector<glm::vec3> vertices = unit_sphere();
    vertex_count_ = static_cast<uint32_t>(vertices.size());
    const auto bytes = std::as_bytes(std::span(vertices));
    vertices_ = DeviceBuffer(device, "sphere", bytes.size(),
                             VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryKind::device);
    const Upload uploads[] = {{&vertices_, bytes, Access::vertex_read}};
    upload(device, uploads);
}

Buffer SphereMesh::import(Frame& frame) const {
    return frame.graph.import_buffer(
        "sphere", {vertices_.size()},
        {.initial = Access::vertex_read, .final = {}, .external = frame.external.add(vertices_.handle())});
}

void SphereMesh::draw(PassContext& context, const Pipeline& pipeline, Buffer mesh, const Frame& frame) const {
    const VkBuffer buffers[] = {context.buffer(mesh), context.buffer(frame.spheres)};
    const VkDeviceSize starts[] = {0, 0};
    vkCmdBindPipeline(context.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.handle());
    vkCmdBindVertexBuffers(context.commands, 0, 2, buffers, starts);
    vkCmdDraw(context.commands, vertex_count_, static_cast<uint32_t>(frame.scene.spheres.size()), 0, 0);
}

} // namespace brittle::engine
