// The geometry of all pieces: one arena of vertices and one of indices, and what is drawn of them.
//
// Pieces come and go without a wait for the device. Where a piece lies is decided here at once; its geometry is copied
// by the next frame, in a pass of its own (upload_pass.h), so that the frame graph orders the copy after the frames
// that still read what lay there before. Arenas grow by doubling: the same pass moves what is there.
//
//     arena.add(batches);                                   // any number of changes
//     PieceUpload upload = arena.next_upload();             // each frame
//     arena.write_staging(mapped); ... record and submit the copies ...
//     arena.uploaded(retired);                              // only if that was submitted
//
// A piece has up to two draw ranges, side by side: exterior, then interior. Range i is instance i: its command has i as
// first instance, and shaders find its body, material and tint in draws[i] (shaders/shared.h). First come the ranges of
// solid pieces, then those of fading ones, each in the order in which pieces were added or from front to back. The
// lists are made anew for each change: 52 bytes a range.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/core/range_allocator.h"
#include "engine/core/result.h"
#include "engine/gpu/memory.h"
#include "engine/render/piece_batch.h"
#include "engine/render/scene.h"
#include "shaders/shared.h"

namespace brittle::engine {

class Device;

// The arenas: positions and normals (glm::vec3) beside each other, indices (uint32_t).
inline constexpr size_t piece_arenas = 3;
using PieceBuffers = std::array<DeviceBuffer, piece_arenas>;

// What the device is to copy before it draws the arenas.
struct PieceUpload {
    using Copies = std::array<std::vector<VkBufferCopy>, piece_arenas>; // into each
    struct Staged {
        std::shared_ptr<const DeviceBuffer> buffer;
        Copies copies;
    };

    Copies from_old;
    Copies from_staging;        // of the frame; ascending in it
    uint64_t staging_size = 0;  // bytes to come from the CPU
    std::vector<Staged> staged; // of batches that are in buffers of their own

    [[nodiscard]] bool empty() const;
};

class PieceArena {
  public:
    [[nodiscard]] static const char* name(size_t arena);

    explicit PieceArena(const Device& device) : device_(device) {}

    // Fail with invalid_argument, or throw VulkanFailure, and then change nothing. Renderer says more.
    [[nodiscard]] Result<std::vector<PieceHandle>> add(std::vector<PieceBatch> batches);
    [[nodiscard]] Result<std::vector<PieceHandle>> replace_all(PieceBatch batch);
    [[nodiscard]] Result<void> remove(std::span<const PieceHandle> handles);
    [[nodiscard]] Result<void> fade(std::span<const PieceHandle> handles, float fade);

    [[nodiscard]] uint32_t pieces() const { return static_cast<uint32_t>(pieces_.size()); }
    [[nodiscard]] uint32_t bodies() const { return bodies_; }
    [[nodiscard]] uint32_t draws() const { return draws_; }
    [[nodiscard]] uint32_t solid_draws() const { return solid_draws_; } // the first so many
    [[nodiscard]] uint64_t triangles() const { return triangles_; }
    [[nodiscard]] uint64_t version() const { return version_; } // another one after each change of what follows

    // For each draw range, its data and its command; both spans are of draws() elements.
    struct DrawLists {
        std::span<shared::DrawData> data;
        std::span<VkDrawIndexedIndirectCommand> commands;
    };
    void write_draws(const DrawLists& lists) const;
    // The same with the pieces nearest to the eye first, by the middle of their spheres; `poses` by body.
    void write_draws(const DrawLists& lists, std::span<const BodyPose> poses, const glm::vec3& eye) const;

    [[nodiscard]] const DeviceBuffer& vertices() const { return buffers_[0]; }
    [[nodiscard]] const DeviceBuffer& normals() const { return buffers_[1]; } // for smooth shading
    [[nodiscard]] const DeviceBuffer& indices() const { return buffers_[2]; }
    // That from_old copies from: valid until uploaded().
    [[nodiscard]] const PieceBuffers& old_buffers() const { return old_; }

    [[nodiscard]] PieceUpload next_upload() const;
    void write_staging(std::byte* staging) const; // as next_upload() planned it, of PieceUpload::staging_size bytes
    // The copies were submitted. Appends buffers that may go once the device is done with that submission.
    void uploaded(std::vector<std::shared_ptr<const DeviceBuffer>>& retired);

  private:
    struct Piece {
        PieceHandle handle;
        PieceBatch::Piece batch;                  // its part of the batch
        std::shared_ptr<const PieceBatch> source; // until it was uploaded
        uint32_t vertex, index;                   // where it begins in the arenas
        uint32_t opacity;                         // 255: solid; 0: not drawn
    };
    struct Allocators {
        RangeAllocator vertices, indices;

        [[nodiscard]] bool place(Piece& piece);
        void free(const Piece& piece);
    };

    [[nodiscard]] Result<void> check(std::span<const PieceBatch> batches, size_t others) const;
    [[nodiscard]] Result<std::vector<PieceHandle>> add(std::vector<PieceBatch> batches, Allocators allocators,
                                                       std::vector<Piece> pieces);
    void grow_buffers(const Allocators& allocators);
    [[nodiscard]] Result<std::vector<size_t>> find(std::span<const PieceHandle> handles) const;
    void update_totals();
    // Where the next range goes in the lists, of solid and of fading pieces.
    struct DrawCursors {
        uint32_t solid, fading;
    };
    // What of a piece goes into an arena.
    struct Slice {
        uint64_t to;       // bytes, in the arena
        uint64_t size;     // bytes
        uint64_t from = 0; // bytes, in the arrays of its batch one after the other; if it has one still
        std::span<const std::byte> bytes{}; // likewise
    };
    [[nodiscard]] static Slice slice_of(const Piece& piece, size_t arena);
    static void write_piece(const Piece& piece, const DrawLists& lists, DrawCursors& cursors);

    const Device& device_;
    std::vector<Piece> pieces_; // ascending in handles
    Allocators allocators_;
    PieceBuffers buffers_;
    PieceBuffers old_;                          // what submitted frames read until buffers_ took over; may be none
    std::array<bool, piece_arenas> resident_{}; // whether a submitted frame wrote buffers_
    bool pending_ = false;                      // there is something to upload
    uint32_t last_handle_ = 0;
    uint32_t bodies_ = 0;
    uint32_t draws_ = 0;
    uint32_t solid_draws_ = 0;
    uint64_t triangles_ = 0;
    uint64_t version_ = 1;
};

} // namespace brittle::engine
