// Pieces made ready to be drawn: checked, with normals for smooth shading, in the layout of the renderer's arenas.
// Making one is nearly all of the work of showing pieces and touches no device, so a worker can do it. What is left is
// a copy to where the device reads, and a worker can do that, too.
//
//     Result<PieceBatch> batch = PieceBatch::create(meshes);      // on any thread
//     renderer.stage(*batch);                                     // likewise
//     ...
//     auto handles = renderer.add_pieces(*std::move(batch));      // on the renderer's
//
// Copies of a batch share their geometry.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "engine/core/result.h"
#include "engine/render/scene.h"

namespace brittle::engine {

class DeviceBuffer;

class PieceBatch {
  public:
    // One piece's part of the arrays; indices count from its own first vertex, those of the exterior come first.
    struct Piece {
        uint32_t first_vertex, vertices;
        uint32_t first_index, exterior_indices, interior_indices;
        uint32_t body;
        uint32_t tint;    // linear, as packUnorm4x8, with no alpha
        glm::vec4 sphere; // around it, in the frame of its body: centre, radius

        [[nodiscard]] uint32_t indices() const { return exterior_indices + interior_indices; }
    };

    PieceBatch() = default; // no pieces

    // Copies what it needs. Fails with invalid_argument on an index out of range or more exterior triangles than
    // triangles, with the piece's number, and on more geometry than can be addressed.
    [[nodiscard]] static Result<PieceBatch> create(std::span<const PieceMesh> pieces);

    [[nodiscard]] std::span<const Piece> pieces() const { return pieces_; }
    // Slow to read once they are staged.
    [[nodiscard]] std::span<const glm::vec3> positions() const { return positions_; }
    [[nodiscard]] std::span<const glm::vec3> normals() const { return normals_; } // beside positions
    [[nodiscard]] std::span<const uint32_t> indices() const { return indices_; }

    [[nodiscard]] uint64_t bytes() const; // of the three

    // All of its pieces move with `body` and have the tint: for who makes pieces before he knows.
    void assign(uint32_t body, const glm::vec3& tint);

    // Moves the arrays into this buffer, one after the other: mapped, of so many bytes or more.
    void move_to(std::shared_ptr<const DeviceBuffer> buffer);
    [[nodiscard]] const std::shared_ptr<const DeviceBuffer>& staged() const { return staged_; } // that buffer, or null

  private:
    struct Arrays {
        std::vector<glm::vec3> positions, normals;
        std::vector<uint32_t> indices;
    };
    void add(const PieceMesh& piece, Arrays& arrays);

    std::vector<Piece> pieces_;
    std::span<const glm::vec3> positions_, normals_;
    std::span<const uint32_t> indices_;
    // What the spans lie in: one of the two.
    std::shared_ptr<const Arrays> arrays_;
    std::shared_ptr<const DeviceBuffer> staged_;
};

} // namespace brittle::engine
