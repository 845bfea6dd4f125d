#include "engine/render/piece_batch.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "engine/gpu/memory.h"
#include "engine/render/smooth_normals.h"

namespace brittle::engine {

namespace {

Error invalid(size_t piece, const std::string& what) {
    return {Status::invalid_argument, "cannot draw piece " + std::to_string(piece) + ": " + what};
}

Result<void> check_piece(size_t index, const PieceMesh& piece) {
    if (piece.exterior_triangles > piece.triangles.size())
        return invalid(index, "exterior_triangles is " + std::to_string(piece.exterior_triangles) + ", but it has only "
                                  + std::to_string(piece.triangles.size()) + " triangles");
    for (const auto& [triangles, what] : {std::pair(piece.triangles, "triangle "), {piece.neighbours, "neighbour "}})
        for (size_t t = 0; t < triangles.size(); ++t) {
            const glm::uvec3 corner = triangles[t];
            const uint32_t largest = std::max({corner.x, corner.y, corner.z});
            if (largest >= piece.positions.size())
                return invalid(index, what + std::to_string(t) + " has vertex index " + std::to_string(largest)
                                          + ", but there are only " + std::to_string(piece.positions.size())
                                          + " vertices");
        }
    return {};
}

// Returns a bounding sphere around the centre of the bounding box; it is not the smallest one.
glm::vec4 sphere_around(std::span<const glm::vec3> positions) {
    if (positions.empty()) return glm::vec4(0.0f);
    glm::vec3 low = positions[0], high = positions[0];
    for (const glm::vec3& p : positions) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    const glm::vec3 centre = (low + high) * 0.5f;
    float squared = 0.0f;
    for (const glm::vec3& p : positions) squared = std::max(squared, glm::dot(p - centre, p - centre));
    return {centre, std::sqrt(squared)};
}

} // namespace

Result<PieceBatch> PieceBatch::create(std::span<const PieceMesh> pieces) {
    size_t vertices = 0, triangles = 0;
    for (size_t i = 0; i < pieces.size(); ++i) {
        if (Result<void> valid = check_piece(i, pieces[i]); !valid) return valid.error();
        vertices += pieces[i].positions.size() + 3 * size_t{pieces[i].exterior_triangles}; // bound after splitting
        triangles += pieces[i].triangles.size();
    }
    // Vertex offsets are signed 32 bits, first indices unsigned 32 bits.
    if (vertices > std::numeric_limits<int32_t>::max() || triangles > std::numeric_limits<uint32_t>::max() / 3)
        return Error{Status::invalid_argument, "cannot draw " + std::to_string(pieces.size()) + " pieces of "
                                                   + std::to_string(triangles) + " triangles: too many to address"};
    PieceBatch batch;
    batch.pieces_.reserve(pieces.size());
    const auto arrays = std::make_shared<Arrays>();
    arrays->indices.reserve(3 * triangles);
    for (const PieceMesh& piece : pieces) batch.add(piece, *arrays);
    batch.positions_ = arrays->positions;
    batch.normals_ = arrays->normals;
    batch.indices_ = arrays->indices;
    batch.arrays_ = arrays;
    return batch;
}

uint64_t PieceBatch::bytes() const {
    return positions_.size_bytes() + normals_.size_bytes() + indices_.size_bytes();
}

void PieceBatch::attach(const PieceAttachment& attachment) {
    for (Piece& piece : pieces_) piece.attachment = attachment;
}

void PieceBatch::move_to(std::shared_ptr<const DeviceBuffer> buffer) {
    assert(buffer->mapped() && buffer->size() >= bytes());
    uint64_t end = 0;
    const auto move = [&]<class T>(std::span<const T>& array) {
        const std::span<T> moved = buffer->mapped_as<T>(end, array.size());
        std::ranges::copy(array, moved.begin());
        end += moved.size_bytes();
        array = moved;
    };
    move(positions_);
    move(normals_);
    move(indices_);
    staged_ = std::move(buffer);
    arrays_.reset();
}

void PieceBatch::add(const PieceMesh& piece, Arrays& arrays) {
    auto& [positions, normals, indices] = arrays;
    size_t own = piece.positions.size();
    if (!piece.neighbours.empty()) {
        own = 0;
        for (const glm::uvec3& t : piece.triangles) own = std::max(own, size_t{1} + std::max({t.x, t.y, t.z}));
    }
    const SmoothSurface exterior =
        smooth_normals(piece.positions, own, piece.triangles.first(piece.exterior_triangles), piece.neighbours);
    const std::span interior = piece.triangles.subspan(piece.exterior_triangles);
    pieces_.push_back({.first_vertex = static_cast<uint32_t>(positions.size()),
                       .vertices = static_cast<uint32_t>(exterior.normals.size()),
                       .first_index = static_cast<uint32_t>(indices.size()),
                       .exterior_indices = static_cast<uint32_t>(3 * exterior.triangles.size()),
                       .interior_indices = static_cast<uint32_t>(3 * interior.size()),
                       .sphere = sphere_around(piece.positions.first(own)),
                       .attachment = {.body = piece.body, .tint = piece.tint}});
    positions.insert(positions.end(), piece.positions.begin(), piece.positions.begin() + static_cast<ptrdiff_t>(own));
    for (const uint32_t vertex : exterior.copies) positions.push_back(piece.positions[vertex]);
    normals.insert(normals.end(), exterior.normals.begin(), exterior.normals.end());
    for (const std::span<const glm::uvec3> range : {std::span<const glm::uvec3>(exterior.triangles), interior})
        for (const glm::uvec3& corner : range) indices.insert(indices.end(), {corner.x, corner.y, corner.z});
}

} // namespace brittle::engine
