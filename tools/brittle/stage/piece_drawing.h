// The geometry of a breakable piece for the renderer, made by the thread that cuts the piece.
//
// A small piece is drawn as one, with positions relative to its centre of mass. A large one is drawn in parts, one for
// each branch of its clusters, with positions in the coordinates of the object. A piece that is cut from another has
// most branches in common with it. Their parts stay on the device; only the others are made.
//
//     std::unique_ptr<PieceDrawing> drawing = draw_piece(solid, cut_from, looks); // on any thread
//     renderer.stage(drawing->batch);
//     ... add drawing->batch, and attach the parts drawn for drawing->kept to the new body ...
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "engine/render/piece_batch.h"
#include "fracture/local/cluster_mesh.h"
#include "physics/cutting/debris.h"
#include "physics/cutting/piece_payload.h"
#include "tools/brittle/stage/mesh_looks.h"

namespace brittle::tools {

// A point of a face that a cut made, for the dust that it throws off.
struct CrackPoint {
    glm::vec3 at{0.0f};     // m, from the piece's centre of mass in the axes of the object
    glm::vec3 normal{0.0f}; // unit
    float area = 0.0f;      // m^2, this piece's half of the part of the crack that the point stands for
};

struct PieceDrawing : physics::PiecePayload {
    static constexpr size_t max_cracks = 12;

    engine::PieceBatch batch;
    std::vector<fracture::ClusterBranch> made; // by piece of the batch; empty for a small piece
    std::vector<fracture::ClusterBranch> kept; // branches that the piece has in common with the one that was cut
    std::vector<CrackPoint> cracks;            // at most max_cracks, on the faces of the last cut
};

// Makes what `solid` does not have in common with the piece that it was cut from; that may be null, as may the looks of
// the object's mesh. Throws a Failure.
[[nodiscard]] std::unique_ptr<PieceDrawing>
draw_piece(const physics::SolidPiece& solid, const physics::SolidPiece* cut_from, const MeshLooks* looks = nullptr);

// The parts of a large piece that draw some of its branches, in their order. Throws a Failure.
[[nodiscard]] engine::PieceBatch draw_branches(const physics::SolidPiece& solid,
                                               std::span<const fracture::ClusterBranch> branches,
                                               const MeshLooks* looks = nullptr);

// What moves the geometry of a piece with this slot.
[[nodiscard]] engine::PieceAttachment attachment_of(const physics::SolidPiece& solid, uint32_t slot,
                                                    const glm::vec3& tint, physics::PieceId id);

} // namespace brittle::tools
