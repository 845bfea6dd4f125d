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
    if (!piece.corners.empty() && piece.corners.size() != 3 * size_t{piece.exterior_triangles})
        return invalid(index, "it has " + std::to_string(piece.corners.size()) + " corners for "
                                  + std::to_string(piece.exterior_triangles) + " exterior triangles");
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

// Gives each vertex the attributes of its corners, and splits those whose corners differ. Interior corners have none.
// `vertices` of the surface are original ones; `looks` receives those of all vertices.
void split_by_look(const PieceMesh& piece, SmoothSurface& exterior, std::vector<glm::uvec3>& interior, size_t vertices,
                   std::vector<CornerLook>& looks) {
    constexpr uint32_t max_compared = 64; // copies of a vertex
    constexpr uint32_t none = ~0u;
    const size_t first = looks.size();
    std::vector<uint32_t> next(exterior.normals.size(), none); // the next copy of a vertex, by look
    std::vector<uint8_t> is_set(exterior.normals.size(), 0);
    looks.resize(first + exterior.normals.size());
    const auto vertex_of = [&](uint32_t vertex, const CornerLook& look) {
        uint32_t at = vertex, compared = 0;
        if (!is_set[vertex]) {
            is_set[vertex] = 1;
            looks[first + vertex] = look;
            return vertex;
        }
        for (; looks[first + at] != look; at = next[at]) {
            if (next[at] != none && ++compared < max_compared) continue;
            const auto made = static_cast<uint32_t>(exterior.normals.size());
            exterior.copies.push_back(vertex < vertices ? vertex : exterior.copies[vertex - vertices]);
            const glm::vec3 normal = exterior.normals[vertex];
            exterior.normals.push_back(normal);
            looks.push_back(look);
            is_set.push_back(1);
            next.push_back(next[at]);
            next[at] = made;
            return made;
        }
        return at;
    };
    for (size_t t = 0; t < exterior.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k)
            exterior.triangles[t][k] =
                vertex_of(exterior.triangles[t][k], piece.corners[3 * t + static_cast<size_t>(k)]);
    for (glm::uvec3& triangle : interior)
        for (int k = 0; k < 3; ++k) triangle[k] = vertex_of(triangle[k], CornerLook{});
}

} // namespace

Result<PieceBatch> PieceBatch::create(std::span<const PieceMesh> pieces) {
    size_t vertices = 0, triangles = 0;
    for (size_t i = 0; i < pieces.size(); ++i) {
        if (Result<void> valid = check_piece(i, pieces[i]); !valid) return valid.error();
        // Bounds after splitting.
        vertices += pieces[i].positions.size() + 3 * size_t{pieces[i].exterior_triangles};
        if (!pieces[i].corners.empty()) vertices += 3 * pieces[i].triangles.size();
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
    const bool has_corners = std::ranges::any_of(pieces, [](const PieceMesh& piece) { return !piece.corners.empty(); });
    for (const PieceMesh& piece : pieces) {
        batch.add(piece, *arrays);
        if (has_corners) arrays->corners.resize(arrays->positions.size());
    }
    batch.corners_ = arrays->corners;
    batch.positions_ = arrays->positions;
    batch.normals_ = arrays->normals;
    batch.indices_ = arrays->indices;
    batch.arrays_ = arrays;
    return batch;
}

uint64_t PieceBatch::bytes() const {
    return positions_.size_bytes() + normals_.size_bytes() + indices_.size_bytes() + corners_.size_bytes();
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
    move(corners_);
    staged_ = std::move(buffer);
    arrays_.reset();
}

void PieceBatch::add(const PieceMesh& piece, Arrays& arrays) {
    auto& [positions, normals, indices, corners] = arrays;
    size_t own = piece.positions.size();
    if (!piece.neighbours.empty()) {
        own = 0;
        for (const glm::uvec3& t : piece.triangles) own = std::max(own, size_t{1} + std::max({t.x, t.y, t.z}));
    }
    SmoothSurface exterior =
        smooth_normals(piece.positions, own, piece.triangles.first(piece.exterior_triangles), piece.neighbours);
    std::span<const glm::uvec3> interior = piece.triangles.subspan(piece.exterior_triangles);
    std::vector<glm::uvec3> own_interior;
    if (!piece.corners.empty()) {
        own_interior.assign(interior.begin(), interior.end());
        corners.resize(positions.size());
        split_by_look(piece, exterior, own_interior, own, corners);
        interior = own_interior;
    }
    pieces_.push_back({.first_vertex = static_cast<uint32_t>(positions.size()),
                       .vertices = static_cast<uint32_t>(exterior.normals.size()),
                       .first_index = static_cast<uint32_t>(indices.size()),
                       .exterior_indices = static_cast<uint32_t>(3 * exterior.triangles.size()),
                       .interior_indices = static_cast<uint32_t>(3 * interior.size()),
                       .sphere = sphere_around(piece.positions.first(own)),
                       .attachment = {.body = piece.body, .tint = piece.tint, .centre = piece.centre},
                       .has_corners = !piece.corners.empty()});
    positions.insert(positions.end(), piece.positions.begin(), piece.positions.begin() + static_cast<ptrdiff_t>(own));
    for (const uint32_t vertex : exterior.copies) positions.push_back(piece.positions[vertex]);
    normals.insert(normals.end(), exterior.normals.begin(), exterior.normals.end());
    for (const std::span<const glm::uvec3> range : {std::span<const glm::uvec3>(exterior.triangles), interior})
        for (const glm::uvec3& corner : range) indices.insert(indices.end(), {corner.x, corner.y, corner.z});
}

} // namespace brittle::engine
