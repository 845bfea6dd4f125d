// The mesh of a unit sphere with 128 triangles, instanced for Scene::spheres as marks and in the shadow map.
//
//     const Buffer mesh = sphere.import(frame);                      // in a pass's declaration
//     pass.read(mesh, Access::vertex_read); pass.read(frame.spheres, Access::vertex_read);
//     sphere.draw(context, pipeline, mesh, frame);                   // in its execute function
//
// Pipelines use the vertex attributes below: a point of the unit sphere at location 0, centre and radius at location 1.
#pragma once

#include <array>
#include <cstdint>

#include "engine/gpu/memory.h"
#include "engine/gpu/pipeline.h"
#include "engine/render/frame.h"

namespace brittle::engine {

class SphereMesh {
  public:
    static constexpr std::array<VkVertexInputBindingDescription, 2> bindings{
        {{0, sizeof(glm::vec3), VK_VERTEX_INPUT_RATE_VERTEX}, {1, sizeof(Sphere), VK_VERTEX_INPUT_RATE_INSTANCE}}};
    static constexpr std::array<VkVertexInputAttributeDescription, 2> attributes{
        {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0}, {1, 1, VK_FORMAT_R32G32B32A32_SFLOAT, 0}}};

    explicit SphereMesh(const Device& device); // uploads the mesh and waits for the copy

    [[nodiscard]] Buffer import(Frame& frame) const;
    // Records one draw of all spheres of the scene, which must have at least one.
    void draw(PassContext& context, const Pipeline& pipeline, Buffer mesh, const Frame& frame) const;

  private:
    DeviceBuffer vertices_; // a triangle list
    uint32_t vertex_count_ = 0;
};

} // namespace brittle::engine
