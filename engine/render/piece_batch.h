// A batch of pieces prepared for drawing: checked, with normals for smooth shading, in the layout of the renderer's
// arenas. Its creation is nearly all of the work of adding pieces and uses no device, so a worker thread can do it. A
// worker can also copy the batch to memory that the device reads.
//
//     Result<PieceBatch> batch = PieceBatch::create(meshes);      // on any thread
//     renderer.stage(*batch);                                     // on any thread
//     ...
//     auto handles = renderer.add_pieces(*std::move(batch));      // on the renderer's thread
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
    // The ranges of one piece in the arrays. Its indices are relative to its first vertex; exterior indices come first.
    struct Piece {
        uint32_t first_vertex, vertices;
        uint32_t first_index, exterior_indices, interior_indices;
        glm::vec4 sphere; // bounding sphere in the frame of the positions: centre, radius
        PieceAttachment attachment;
        bool has_corners = false; // with attributes of its own in corners()

        [[nodiscard]] uint32_t indices() const { return exterior_indices + interior_indices; }
    };

    PieceBatch() = default; // no pieces

    // Copies the meshes. Fails with invalid_argument, and the piece's number, on an index out of range, more exterior
    // triangles than triangles or a wrong number of corners, and on more geometry than 32-bit offsets can address.
    [[nodiscard]] static Result<PieceBatch> create(std::span<const PieceMesh> pieces);

    [[nodiscard]] std::span<const Piece> pieces() const { return pieces_; }
    // The arrays of all pieces. A staged batch has them in mapped memory, which may be slow to read.
    [[nodiscard]] std::span<const glm::vec3> positions() const { return positions_; }
    [[nodiscard]] std::span<const glm::vec3> normals() const { return normals_; } // parallel to positions()
    [[nodiscard]] std::span<const uint32_t> indices() const { return indices_; }
    [[nodiscard]] std::span<const CornerLook> corners() const { return corners_; } // parallel to positions(); or none

    [[nodiscard]] uint64_t bytes() const; // size of the four arrays

    // Attaches all pieces, for callers that create the batch before they know the body.
    void attach(const PieceAttachment& attachment);

    // Moves the arrays into a mapped buffer of at least bytes() bytes, one array after the other.
    void move_to(std::shared_ptr<const DeviceBuffer> buffer);
    [[nodiscard]] const std::shared_ptr<const DeviceBuffer>& staged() const { return staged_; } // the buffer, or null

  private:
    struct Arrays {
        std::vector<glm::vec3> positions, normals;
        std::vector<uint32_t> indices;
        std::vector<CornerLook> corners;
    };
    void add(const PieceMesh& piece, Arrays& arrays);

    std::vector<Piece> pieces_;
    std::span<const glm::vec3> positions_, normals_;
    std::span<const uint32_t> indices_;
    std::span<const CornerLook> corners_;
    // The owner of the spans' memory; the other pointer is null.
    std::shared_ptr<const Arrays> arrays_;
    std::shared_ptr<const DeviceBuffer> staged_;
};

} // namespace brittle::engine
