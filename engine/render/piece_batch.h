// Pieces made ready to be drawn: checked, with normals for smooth shading, in the layout of the renderer's arenas.
// Making one is nearly all of the work of showing pieces and touches no device, so a worker can do it; handing it to
// Renderer::add_pieces() moves it.
//
//     Result<PieceBatch> batch = PieceBatch::create(meshes);      // on any thread
//     ...
//     auto handles = renderer.add_pieces(*std::move(batch));      // on the renderer's
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "engine/core/result.h"
#include "engine/render/scene.h"

namespace brittle::engine {

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
    [[nodiscard]] std::span<const glm::vec3> positions() const { return positions_; }
    [[nodiscard]] std::span<const glm::vec3> normals() const { return normals_; } // beside positions
    [[nodiscard]] std::span<const uint32_t> indices() const { return indices_; }

    // Takes the pieces of another batch in: a copy of its arrays, whatever they cost to make. All move with `body` and
    // have the tint. Asserts that the sum can be addressed.
    void append(const PieceBatch& other, uint32_t body, const glm::vec3& tint);

  private:
    void add(const PieceMesh& piece);

    std::vector<Piece> pieces_;
    std::vector<glm::vec3> positions_;
    std::vector<glm::vec3> normals_;
    std::vector<uint32_t> indices_;
};

} // namespace brittle::engine
