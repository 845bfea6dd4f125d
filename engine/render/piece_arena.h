// The geometry of all pieces on the device, in one arena each for positions, normals, indices and attributes of
// corners, and the draw ranges of the pieces.
//
// Pieces are added and removed without waiting for the device. The place of a piece is allocated at once. The next
// frame copies its geometry in a pass of its own (upload_pass.h), so that the frame graph orders the copy after the
// frames that still read the old contents. Arenas grow by doubling; the same pass moves their contents.
// Copies of a piece share its geometry, which keeps its place as long as one of them is there.
//
//     arena.add(batches);                                   // any number of changes
//     PieceUpload upload = arena.next_upload();             // in each frame
//     arena.write_staging(mapped);
//     ... record and submit the copies ...
//     arena.uploaded(retired);                              // only if the copies were submitted
//
// A piece has up to two consecutive draw ranges: exterior, then interior. Range i is instance i: its command has i as
// first instance, and shaders find its body, material and tint in draws[i] (shaders/shared.h). The ranges of solid
// pieces precede those of fading pieces; within each group, pieces are in the order of adding or from front to back.
// Every change rebuilds the lists, at 84 bytes for each range. Not thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/core/range_allocator.h"
#include "engine/core/result.h"
#include "engine/gpu/memory.h"
#include "engine/render/piece_batch.h"
#include "engine/render/scene.h"
#include "shaders/shared.h"

namespace brittle::engine {

class Device;

// The arenas: positions and normals (glm::vec3), indices (uint32_t), and corner attributes (CornerLook). All but the
// indices have parallel elements. The corner attributes have no memory until some are needed.
inline constexpr size_t piece_arenas = 4;
inline constexpr size_t index_arena = 2, corner_arena = 3;
using PieceBuffers = std::array<DeviceBuffer, piece_arenas>;

// The copies that the device must make before it draws from the arenas.
struct PieceUpload {
    using Copies = std::array<std::vector<VkBufferCopy>, piece_arenas>; // by destination arena
    struct Staged {
        std::shared_ptr<const DeviceBuffer> buffer;
        Copies copies;
    };

    Copies from_old;            // from the buffers before an arena grew
    Copies from_staging;        // from the frame's staging buffer, in ascending order
    uint64_t staging_size = 0;  // bytes of the frame's staging buffer
    std::vector<Staged> staged; // from the buffers of staged batches

    [[nodiscard]] bool empty() const;
};

class PieceArena {
  public:
    [[nodiscard]] static const char* name(size_t arena);

    explicit PieceArena(const Device& device) : device_(device) {}

    // The changes of Renderer's functions of similar names. They fail with invalid_argument or throw VulkanFailure, and
    // then change nothing.
    [[nodiscard]] Result<std::vector<PieceHandle>> add(std::vector<PieceBatch> batches);
    [[nodiscard]] Result<std::vector<PieceHandle>> replace_all(PieceBatch batch);
    [[nodiscard]] Result<std::vector<PieceHandle>> copy(std::span<const PieceHandle> handles,
                                                        const PieceAttachment& attachment);
    [[nodiscard]] Result<void> remove(std::span<const PieceHandle> handles);
    [[nodiscard]] Result<void> fade(std::span<const PieceHandle> handles, float fade);
    [[nodiscard]] Result<void> attach(std::span<const PieceHandle> handles, const PieceAttachment& attachment);

    [[nodiscard]] uint32_t pieces() const { return static_cast<uint32_t>(contents_.pieces.size()); }
    [[nodiscard]] uint32_t bodies() const { return bodies_; }
    [[nodiscard]] uint32_t draws() const { return draws_; }
    [[nodiscard]] uint32_t solid_draws() const { return solid_draws_; } // the first of draws(); the rest are fading
    [[nodiscard]] uint64_t triangles() const { return triangles_; }
    [[nodiscard]] uint64_t version() const { return version_; } // a number that changes when the draw lists change

    // Makes the arena of corner attributes, for the view of materials. Throws VulkanFailure.
    void need_corners();

    // The data and the command of each draw range; both spans have draws() elements.
    struct DrawLists {
        std::span<shared::DrawData> data;
        std::span<VkDrawIndexedIndirectCommand> commands;
    };
    void write_draws(const DrawLists& lists) const;
    // Writes the lists with pieces sorted by the distance of their spheres' centres from the eye, nearest first.
    // `poses` is indexed by body.
    void write_draws(const DrawLists& lists, std::span<const BodyPose> poses, const glm::vec3& eye) const;

    [[nodiscard]] const DeviceBuffer& vertices() const { return buffers_[0]; }
    [[nodiscard]] const DeviceBuffer& normals() const { return buffers_[1]; } // for smooth shading
    [[nodiscard]] const DeviceBuffer& indices() const { return buffers_[2]; }
    [[nodiscard]] const DeviceBuffer& corners() const { return buffers_[corner_arena]; } // null until needed
    // The sources of PieceUpload::from_old, valid until uploaded(); null buffers where an arena has not grown.
    [[nodiscard]] const PieceBuffers& old_buffers() const { return old_; }

    [[nodiscard]] PieceUpload next_upload() const;
    void
    write_staging(std::byte* staging) const; // writes the PieceUpload::staging_size bytes that next_upload() planned
    // Records that the copies were submitted. Appends the buffers to free when the device has finished the submission.
    void uploaded(std::vector<std::shared_ptr<const DeviceBuffer>>& retired);

  private:
    // The geometry of a piece and of its copies.
    struct Geometry {
        PieceBatch::Piece batch;                  // its ranges in the batch
        std::shared_ptr<const PieceBatch> source; // the batch, until it was uploaded
        uint32_t vertex, index;                   // its first elements in the arenas
    };
    struct Piece {
        PieceHandle handle;
        std::shared_ptr<Geometry> geometry;
        PieceAttachment attachment;
        uint32_t opacity; // 255: solid; 0: not drawn; between: fading
    };
    struct Allocators {
        RangeAllocator vertices, indices;

        [[nodiscard]] bool allocate(Geometry& geometry);
        void free(const Geometry& geometry);
    };
    // What a change of the pieces makes anew.
    struct Contents {
        std::vector<Piece> pieces;                         // by ascending handle
        std::vector<std::shared_ptr<Geometry>> geometries; // of the pieces, in the order of adding
        Allocators allocators;
    };

    [[nodiscard]] std::string fault_of_body(uint32_t body) const;
    [[nodiscard]] Result<void> check_count(uint64_t added, size_t others) const;
    [[nodiscard]] Result<void> check(std::span<const PieceBatch> batches, size_t others) const;
    [[nodiscard]] Result<std::vector<PieceHandle>> add(std::vector<PieceBatch> batches, Contents contents);
    void grow_buffers(const Allocators& allocators);
    [[nodiscard]] Result<std::vector<size_t>> find(std::span<const PieceHandle> handles) const;
    void update_totals();
    // The next free indices in the draw lists.
    struct DrawCursors {
        uint32_t solid, fading;
    };
    // The bytes of one geometry in one arena.
    struct Slice {
        uint64_t to;       // offset in the arena, bytes
        uint64_t size;     // bytes
        uint64_t from = 0; // offset in the concatenated arrays of the batch, bytes; only before the upload
        std::span<const std::byte> bytes{}; // the data in the batch; only before the upload
    };
    [[nodiscard]] static Slice slice_of(const Geometry& geometry, size_t arena);
    static void write_piece(const Piece& piece, const DrawLists& lists, DrawCursors& cursors);

    const Device& device_;
    Contents contents_;
    PieceBuffers buffers_;
    PieceBuffers old_;                          // the buffers before growth, read by submitted frames; may be null
    std::array<bool, piece_arenas> resident_{}; // whether a submitted frame has written buffers_
    bool pending_ = false;                      // whether there is an upload to make
    bool needs_corners_ = false;
    uint32_t last_handle_ = 0;
    uint32_t bodies_ = 0;
    uint32_t draws_ = 0;
    uint32_t solid_draws_ = 0;
    uint64_t triangles_ = 0;
    uint64_t version_ = 1;
};

} // namespace brittle::engine
