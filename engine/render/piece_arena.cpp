#include "engine/render/piece_arena.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include <glm/geometric.hpp>
#include <glm/packing.hpp>

#include "engine/gpu/device.h"

namespace brittle::engine {

namespace {

constexpr uint32_t solid = 255;
// Vertex offsets are signed 32 bits, first indices unsigned 32 bits.
constexpr uint32_t max_vertices = std::numeric_limits<int32_t>::max();
constexpr uint32_t max_indices = std::numeric_limits<uint32_t>::max();

struct ArenaKind {
    const char* name;
    uint64_t element; // bytes
    VkBufferUsageFlags usage;
};
constexpr std::array<ArenaKind, piece_arenas> kinds{
    {{"piece vertices", sizeof(glm::vec3), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT},
     {"piece normals", sizeof(glm::vec3), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT},
     {"piece indices", sizeof(uint32_t), VK_BUFFER_USAGE_INDEX_BUFFER_BIT},
     {"piece corners", sizeof(CornerLook), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT}}};

// Grows the capacity by at least `size`, and at least to twice its value, so that arenas are rarely moved when pieces
// are added one by one. Returns false if that exceeds `limit`.
bool grow_by(RangeAllocator& space, uint64_t size, uint64_t limit) {
    const uint64_t needed = uint64_t{space.capacity()} + size;
    if (needed > limit) return false;
    space.grow(static_cast<uint32_t>(std::min(limit, std::max(needed, 2 * uint64_t{space.capacity()}))));
    return true;
}

// Allocates a range, and grows the space if no free range is long enough. Returns nullopt beyond `limit`.
std::optional<uint32_t> allocate_or_grow(RangeAllocator& space, uint32_t size, uint64_t limit) {
    if (const std::optional<uint32_t> begin = space.allocate(size)) return begin;
    if (!grow_by(space, size, limit)) return std::nullopt;
    return space.allocate(size);
}

// Grows the space until its free elements add up to `size`, so that a large batch causes one growth instead of several.
void reserve(RangeAllocator& space, uint64_t size, uint64_t limit) {
    const uint64_t unused = space.capacity() - space.used();
    if (size > unused) (void)grow_by(space, size - unused, limit);
}

// Appends a copy, or extends the last one if the two are contiguous.
void append(std::vector<VkBufferCopy>& copies, const VkBufferCopy& next) {
    if (next.size == 0) return;
    if (!copies.empty()) {
        VkBufferCopy& last = copies.back();
        if (last.srcOffset + last.size == next.srcOffset && last.dstOffset + last.size == next.dstOffset) {
            last.size += next.size;
            return;
        }
    }
    copies.push_back(next);
}

} // namespace

bool PieceUpload::empty() const {
    const auto none = [](const Copies& copies) {
        return std::ranges::all_of(copies, &std::vector<VkBufferCopy>::empty);
    };
    return staged.empty() && none(from_old) && none(from_staging);
}

const char* PieceArena::name(size_t arena) {
    return kinds[arena].name;
}

bool PieceArena::Allocators::allocate(Geometry& geometry) {
    const std::optional<uint32_t> vertex = allocate_or_grow(vertices, geometry.batch.vertices, max_vertices);
    const std::optional<uint32_t> index = allocate_or_grow(indices, geometry.batch.indices(), max_indices);
    if (!vertex || !index) return false;
    geometry.vertex = *vertex;
    geometry.index = *index;
    return true;
}

void PieceArena::Allocators::free(const Geometry& geometry) {
    vertices.free(geometry.vertex, geometry.batch.vertices);
    indices.free(geometry.index, geometry.batch.indices());
}

// Returns why the device cannot draw pieces of a body; empty if it can.
std::string PieceArena::fault_of_body(uint32_t body) const {
    const uint64_t max_bodies = device_.limits().maxStorageBufferRange / sizeof(shared::Pose);
    if (body < max_bodies) return {};
    return "its body is number " + std::to_string(body) + ", the device takes " + std::to_string(max_bodies)
           + " bodies";
}

Result<void> PieceArena::check_count(uint64_t added, size_t others) const {
    const uint64_t storage = device_.limits().maxStorageBufferRange;
    const uint64_t all = others + added;
    if (2 * all > storage / sizeof(shared::DrawData) || added > std::numeric_limits<uint32_t>::max() - last_handle_)
        return Error{Status::invalid_argument, "cannot draw " + std::to_string(all) + " pieces: too many to address"};
    return {};
}

Result<void> PieceArena::check(std::span<const PieceBatch> batches, size_t others) const {
    uint64_t added = 0;
    for (const PieceBatch& batch : batches)
        for (const PieceBatch::Piece& piece : batch.pieces()) {
            if (const std::string fault = fault_of_body(piece.attachment.body); !fault.empty())
                return Error{Status::invalid_argument, "cannot draw piece " + std::to_string(added) + ": " + fault};
            ++added;
        }
    return check_count(added, others);
}

Result<std::vector<PieceHandle>> PieceArena::add(std::vector<PieceBatch> batches) {
    if (Result<void> valid = check(batches, contents_.pieces.size()); !valid) return valid.error();
    return add(std::move(batches), contents_);
}

Result<std::vector<PieceHandle>> PieceArena::replace_all(PieceBatch batch) {
    if (Result<void> valid = check({&batch, 1}, 0); !valid) return valid.error();
    Contents emptied{{}, {}, contents_.allocators};
    for (const auto& geometry : contents_.geometries) emptied.allocators.free(*geometry);
    return add({std::move(batch)}, std::move(emptied));
}

// Works on a copy of the contents until no step can fail.
Result<std::vector<PieceHandle>> PieceArena::add(std::vector<PieceBatch> batches, Contents contents) {
    auto& [pieces, geometries, allocators] = contents;
    uint64_t vertices = 0, indices = 0, added = 0;
    for (const PieceBatch& batch : batches) {
        vertices += batch.positions().size();
        indices += batch.indices().size();
        added += batch.pieces().size();
    }
    reserve(allocators.vertices, vertices, max_vertices);
    reserve(allocators.indices, indices, max_indices);
    std::vector<PieceHandle> handles;
    handles.reserve(added);
    pieces.reserve(pieces.size() + added);
    geometries.reserve(geometries.size() + added);
    uint32_t handle = last_handle_;
    for (PieceBatch& batch : batches) {
        const auto source = std::make_shared<const PieceBatch>(std::move(batch));
        for (const PieceBatch::Piece& batch_piece : source->pieces()) {
            const auto geometry = std::make_shared<Geometry>(Geometry{batch_piece, source, 0, 0});
            if (!allocators.allocate(*geometry))
                return Error{Status::invalid_argument, "cannot draw more than " + std::to_string(pieces.size())
                                                           + " pieces: their geometry is too large to address"};
            handles.push_back({++handle});
            pieces.push_back({handles.back(), geometry, batch_piece.attachment, solid});
            geometries.push_back(geometry);
        }
    }
    needs_corners_ = needs_corners_ || std::ranges::any_of(geometries, [](const auto& geometry) {
                         return geometry->batch.has_corners;
                     });
    grow_buffers(allocators);
    pending_ = pending_ || !handles.empty();
    contents_ = std::move(contents);
    last_handle_ = handle;
    update_totals();
    return handles;
}

Result<std::vector<PieceHandle>> PieceArena::copy(std::span<const PieceHandle> handles,
                                                  const PieceAttachment& attachment) {
    if (const std::string fault = fault_of_body(attachment.body); !fault.empty())
        return Error{Status::invalid_argument, "cannot copy pieces: " + fault};
    if (Result<void> valid = check_count(handles.size(), contents_.pieces.size()); !valid) return valid.error();
    const Result<std::vector<size_t>> found = find(handles);
    if (!found) return found.error();
    std::vector<PieceHandle> copies;
    std::vector<Piece>& pieces = contents_.pieces;
    copies.reserve(found->size());
    pieces.reserve(pieces.size() + found->size());
    for (const size_t i : *found) {
        copies.push_back({++last_handle_});
        pieces.push_back({copies.back(), pieces[i].geometry, attachment, solid});
    }
    update_totals();
    return copies;
}

void PieceArena::need_corners() {
    if (needs_corners_) return;
    needs_corners_ = true;
    grow_buffers(contents_.allocators);
}

// Grows the buffers to the allocators' capacities. This is the last step of add() that may throw.
void PieceArena::grow_buffers(const Allocators& allocators) {
    const std::array<uint32_t, piece_arenas> capacity{allocators.vertices.capacity(), allocators.vertices.capacity(),
                                                      allocators.indices.capacity(),
                                                      needs_corners_ ? allocators.vertices.capacity() : 0};
    PieceBuffers larger;
    bool grown = false;
    for (size_t i = 0; i < piece_arenas; ++i) {
        const uint64_t bytes = kinds[i].element * capacity[i];
        if (bytes == buffers_[i].size()) continue;
        grown = true;
        larger[i] = {device_, kinds[i].name, bytes,
                     kinds[i].usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                     MemoryKind::device};
    }
    if (!grown) return;
    for (size_t i = 0; i < piece_arenas; ++i) {
        if (!larger[i].handle()) continue;
        // When an arena grows more than once between two frames, only the first buffer was written by a frame.
        if (resident_[i]) old_[i] = std::move(buffers_[i]);
        resident_[i] = false;
        buffers_[i] = std::move(larger[i]);
    }
    pending_ = true;
}

Result<std::vector<size_t>> PieceArena::find(std::span<const PieceHandle> handles) const {
    std::vector<size_t> found;
    found.reserve(handles.size());
    for (const PieceHandle handle : handles) {
        const std::vector<Piece>& pieces = contents_.pieces;
        const auto at = std::ranges::lower_bound(pieces, handle, {}, &Piece::handle);
        if (at == pieces.end() || at->handle != handle)
            return Error{Status::invalid_argument, "there is no piece with the handle " + std::to_string(handle.number)
                                                       + ": it was removed, or never added"};
        found.push_back(static_cast<size_t>(at - pieces.begin()));
    }
    return found;
}

Result<void> PieceArena::remove(std::span<const PieceHandle> handles) {
    Result<std::vector<size_t>> found = find(handles);
    if (!found) return found.error();
    std::ranges::sort(*found);
    found->erase(std::unique(found->begin(), found->end()), found->end());
    std::vector<Piece>& pieces = contents_.pieces;
    size_t kept = 0, next = 0;
    for (size_t i = 0; i < pieces.size(); ++i) {
        if (next < found->size() && (*found)[next] == i) {
            ++next;
            continue;
        }
        if (kept != i) pieces[kept] = std::move(pieces[i]);
        ++kept;
    }
    pieces.resize(kept);
    std::erase_if(contents_.geometries, [&](const std::shared_ptr<Geometry>& geometry) {
        if (geometry.use_count() > 1) return false; // a piece has it
        contents_.allocators.free(*geometry);
        return true;
    });
    update_totals();
    return {};
}

Result<void> PieceArena::fade(std::span<const PieceHandle> handles, float fade) {
    if (!(fade >= 0.0f && fade <= 1.0f))
        return Error{Status::invalid_argument, "pieces cannot fade by " + std::to_string(fade) + ": it must be 0 to 1"};
    Result<std::vector<size_t>> found = find(handles);
    if (!found) return found.error();
    const auto opacity = static_cast<uint32_t>(std::lround((1.0f - fade) * static_cast<float>(solid)));
    for (const size_t i : *found) contents_.pieces[i].opacity = opacity;
    update_totals();
    return {};
}

Result<void> PieceArena::attach(std::span<const PieceHandle> handles, const PieceAttachment& attachment) {
    if (const std::string fault = fault_of_body(attachment.body); !fault.empty())
        return Error{Status::invalid_argument, "cannot attach pieces: " + fault};
    Result<std::vector<size_t>> found = find(handles);
    if (!found) return found.error();
    for (const size_t i : *found) contents_.pieces[i].attachment = attachment;
    update_totals();
    return {};
}

// Recomputes the totals over all pieces, after each change.
void PieceArena::update_totals() {
    bodies_ = draws_ = solid_draws_ = 0;
    triangles_ = 0;
    for (const Piece& piece : contents_.pieces) {
        const PieceBatch::Piece& batch = piece.geometry->batch;
        bodies_ = std::max(bodies_, piece.attachment.body + 1);
        triangles_ += batch.indices() / 3;
        const uint32_t ranges = (batch.exterior_indices > 0) + (batch.interior_indices > 0);
        if (piece.opacity > 0) draws_ += ranges;
        if (piece.opacity == solid) solid_draws_ += ranges;
    }
    ++version_;
}

void PieceArena::write_piece(const Piece& piece, const DrawLists& lists, DrawCursors& cursors) {
    if (piece.opacity == 0) return;
    uint32_t& next = piece.opacity == solid ? cursors.solid : cursors.fading;
    const PieceAttachment& attachment = piece.attachment;
    const Geometry& geometry = *piece.geometry;
    const PieceBatch::Piece& batch = geometry.batch;
    const uint32_t tint = glm::packUnorm4x8(glm::vec4(attachment.tint, 0.0f)) | piece.opacity << 24;
    const uint32_t id = attachment.id == 0 ? piece.handle.number : attachment.id;
    const glm::vec4 offset(attachment.offset, 0.0f);
    const uint32_t surface = std::min(attachment.surface, shared::max_surfaces - 1);
    const auto first_material =
        batch.has_corners ? static_cast<float>(attachment.first_material + 1) : 0.0f; // exact below 2^24
    const glm::vec4 object(attachment.centre, first_material);
    const auto add = [&](uint32_t indices, uint32_t first, uint32_t material) {
        if (indices == 0) return;
        lists.commands[next] = {indices, 1, first, static_cast<int32_t>(geometry.vertex), next};
        lists.data[next] = {attachment.body, 2 * surface + material, tint, id, batch.sphere + offset, offset, object};
        ++next;
    };
    add(batch.exterior_indices, geometry.index, shared::material_exterior);
    add(batch.interior_indices, geometry.index + batch.exterior_indices, shared::material_interior);
}

void PieceArena::write_draws(const DrawLists& lists) const {
    DrawCursors cursors{0, solid_draws_};
    for (const Piece& piece : contents_.pieces) write_piece(piece, lists, cursors);
}

void PieceArena::write_draws(const DrawLists& lists, std::span<const BodyPose> poses, const glm::vec3& eye) const {
    // The keys are unique integers: the bits of the squared distance, whose order is that of non-negative floats, and
    // the index in the list.
    const std::vector<Piece>& pieces = contents_.pieces;
    std::vector<uint64_t> order(pieces.size());
    for (size_t i = 0; i < order.size(); ++i) {
        const PieceAttachment& attachment = pieces[i].attachment;
        const BodyPose& pose = poses[attachment.body];
        const glm::vec3 own(pieces[i].geometry->batch.sphere);
        const glm::vec3 middle = pose.rotation * (pose.scale * (own + attachment.offset));
        const glm::vec3 way = middle + pose.position - eye;
        const float squared = glm::dot(way, way);
        const uint64_t far = std::isnan(squared) ? ~0u : std::bit_cast<uint32_t>(squared);
        order[i] = far << 32 | i;
    }
    std::ranges::sort(order);
    DrawCursors cursors{0, solid_draws_};
    for (const uint64_t key : order) write_piece(pieces[key & ~0u], lists, cursors);
}

PieceArena::Slice PieceArena::slice_of(const Geometry& geometry, size_t arena) {
    const auto& [batch, source, vertex, index] = geometry;
    const uint64_t element = kinds[arena].element;
    const bool of_indices = arena == index_arena;
    if (arena == corner_arena && !batch.has_corners) return {.to = 0, .size = 0};
    Slice slice{.to = element * (of_indices ? index : vertex),
                .size = element * (of_indices ? batch.indices() : batch.vertices)};
    if (!source) return slice;
    const std::array<std::span<const std::byte>, piece_arenas> arrays{
        std::as_bytes(source->positions()), std::as_bytes(source->normals()), std::as_bytes(source->indices()),
        std::as_bytes(source->corners())};
    const uint64_t first = element * (of_indices ? batch.first_index : batch.first_vertex);
    slice.bytes = arrays[arena].subspan(first, slice.size);
    for (size_t before = 0; before < arena; ++before) slice.from += arrays[before].size();
    slice.from += first;
    return slice;
}

PieceUpload PieceArena::next_upload() const {
    PieceUpload upload;
    if (!pending_) return upload;
    for (size_t i = 0; i < piece_arenas; ++i) {
        size_t at = 0; // index in upload.staged; the geometries of a batch are consecutive
        for (const auto& geometry : contents_.geometries) {
            const Slice slice = slice_of(*geometry, i);
            if (!geometry->source) {
                if (old_[i].handle()) append(upload.from_old[i], {slice.to, slice.to, slice.size});
            } else if (const auto& buffer = geometry->source->staged()) {
                at += at < upload.staged.size() && upload.staged[at].buffer != buffer;
                if (at == upload.staged.size()) upload.staged.push_back({buffer, {}});
                append(upload.staged[at].copies[i], {slice.from, slice.to, slice.size});
            } else {
                append(upload.from_staging[i], {upload.staging_size, slice.to, slice.size});
                upload.staging_size += slice.size;
            }
        }
    }
    return upload;
}

void PieceArena::write_staging(std::byte* staging) const {
    for (size_t i = 0; i < piece_arenas; ++i)
        for (const auto& geometry : contents_.geometries) {
            if (!geometry->source || geometry->source->staged()) continue;
            const Slice slice = slice_of(*geometry, i);
            if (slice.bytes.empty()) continue;
            std::memcpy(staging, slice.bytes.data(), slice.bytes.size());
            staging += slice.bytes.size();
        }
}

void PieceArena::uploaded(std::vector<std::shared_ptr<const DeviceBuffer>>& retired) {
    if (!pending_) return;
    for (const auto& geometry : contents_.geometries) {
        if (!geometry->source) continue;
        const auto& buffer = geometry->source->staged();
        if (buffer && (retired.empty() || retired.back() != buffer)) retired.push_back(buffer);
        geometry->source.reset();
    }
    for (size_t i = 0; i < piece_arenas; ++i) {
        resident_[i] = true;
        if (old_[i].handle()) retired.push_back(std::make_shared<const DeviceBuffer>(std::move(old_[i])));
    }
    pending_ = false;
}

} // namespace brittle::engine
