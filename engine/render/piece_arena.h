// The geometry of all pieces: one vertex and one index arena, the draw ranges in them, and the indirect
// commands that draw all of it in one multi-draw.
//
// A piece has up to two draw ranges: exterior, then interior. Range i is instance i: its indirect command has
// i as first instance, and shaders find its body, material and tint in draws[i] (shaders/shared.h).
#pragma once

#include <cstdint>
#include <span>

#include "engine/core/result.h"
#include "engine/gpu/memory.h"
#include "engine/graph/access.h"
#include "engine/render/scene.h"

namespace brittle::engine {

class Device;

class PieceArena {
  public:
    // What passes do with the buffers, once they are uploaded.
    static constexpr AccessSet draw_data_accesses =
        Access::storage_read_vertex | Access::storage_read_compute;
    static constexpr AccessSet commands_accesses = Access::indirect_read | Access::storage_read_compute;

    // No pieces; with buffers all the same, since descriptors must name some.
    explicit PieceArena(const Device& device);

    // Copies the pieces to the device. Fails with invalid_argument as Renderer::set_pieces() says; throws
    // VulkanFailure.
    [[nodiscard]] static Result<PieceArena> create(const Device& device, std::span<const PieceMesh> pieces);

    [[nodiscard]] uint32_t pieces() const { return pieces_; }
    [[nodiscard]] uint32_t bodies() const { return bodies_; }
    [[nodiscard]] uint32_t draws() const { return draws_; }
    [[nodiscard]] uint64_t triangles() const { return triangles_; }

    [[nodiscard]] const DeviceBuffer& vertices() const { return vertices_; } // glm::vec3
    [[nodiscard]] const DeviceBuffer& normals() const { return normals_; }   // glm::vec3, for smooth shading
    [[nodiscard]] const DeviceBuffer& indices() const { return indices_; }   // uint32_t
    [[nodiscard]] const DeviceBuffer& draw_data() const { return draw_data_; } // shared::DrawData
    [[nodiscard]] const DeviceBuffer& commands() const { return commands_; }   // VkDrawIndexedIndirectCommand

  private:
    struct Arrays;
    PieceArena(const Device& device, const Arrays& arrays);

    uint32_t pieces_ = 0;
    uint32_t bodies_ = 0;
    uint32_t draws_ = 0;
    uint64_t triangles_ = 0;
    DeviceBuffer vertices_;
    DeviceBuffer normals_;
    DeviceBuffer indices_;
    DeviceBuffer draw_data_;
    DeviceBuffer commands_;
};

} // namespace brittle::engine
