#include "engine/render/piece_arena.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/packing.hpp>

#include "engine/gpu/device.h"
#include "engine/graph/upload.h"
#include "engine/render/smooth_normals.h"
#include "shaders/shared.h"

namespace brittle::engine {

struct PieceArena::Arrays {
    std::vector<glm::vec3> vertices;
    std::vector<glm::vec3> normals;
    std::vector<uint32_t> indices;
    std::vector<shared::DrawData> draws;
    std::vector<VkDrawIndexedIndirectCommand> commands;
    uint32_t pieces = 0;
    uint32_t bodies = 0;
};

namespace {

Error invalid(size_t piece, const std::string& what) {
    return {Status::invalid_argument, "cannot draw piece " + std::to_string(piece) + ": " + what};
}

Result<void> check_piece(size_t index, const PieceMesh& piece, uint32_t most_bodies) {
    if (piece.exterior_triangles > piece.triangles.size())
        return invalid(index, "it says that " + std::to_string(piece.exterior_triangles) + " of its "
                                  + std::to_string(piece.triangles.size()) + " triangles are exterior");
    if (piece.body >= most_bodies)
        return invalid(index, "its body is number " + std::to_string(piece.body) + ", the device takes "
                                  + std::to_string(most_bodies) + " bodies");
    for (size_t t = 0; t < piece.triangles.size(); ++t) {
        const glm::uvec3 corner = piece.triangles[t];
        const uint32_t largest = std::max({corner.x, corner.y, corner.z});
        if (largest >= piece.positions.size())
            return invalid(index, "triangle " + std::to_string(t) + " names vertex " + std::to_string(largest)
                                      + " of " + std::to_string(piece.positions.size()));
    }
    return {};
}

// Around all of the piece: about the middle of its box, so not the smallest.
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

DeviceBuffer arena(const Device& device, const char* name, uint64_t size, VkBufferUsageFlags usage) {
    return {device, name, size, usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryKind::device};
}

template<class T>
std::span<const std::byte> bytes_of(const std::vector<T>& values) {
    return std::as_bytes(std::span(values));
}

} // namespace

PieceArena::PieceArena(const Device& device) : PieceArena(device, Arrays{}) {}

PieceArena::PieceArena(const Device& device, const Arrays& arrays)
    : pieces_(arrays.pieces), bodies_(arrays.bodies), draws_(static_cast<uint32_t>(arrays.draws.size())),
      triangles_(arrays.indices.size() / 3),
      vertices_(arena(device, "piece vertices", bytes_of(arrays.vertices).size(),
                      VK_BUFFER_USAGE_VERTEX_BUFFER_BIT)),
      normals_(
          arena(device, "piece normals", bytes_of(arrays.normals).size(), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT)),
      indices_(
          arena(device, "piece indices", bytes_of(arrays.indices).size(), VK_BUFFER_USAGE_INDEX_BUFFER_BIT)),
      draw_data_(
          arena(device, "draw data", bytes_of(arrays.draws).size(), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT)),
      commands_(arena(device, "draw commands", bytes_of(arrays.commands).size(),
                      VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT)) {
    const Upload uploads[] = {{&vertices_, bytes_of(arrays.vertices), Access::vertex_read},
                              {&normals_, bytes_of(arrays.normals), Access::vertex_read},
                              {&indices_, bytes_of(arrays.indices), Access::index_read},
                              {&draw_data_, bytes_of(arrays.draws), draw_data_accesses},
                              {&commands_, bytes_of(arrays.commands), commands_accesses}};
    upload(device, uploads);
}

Result<PieceArena> PieceArena::create(const Device& device, std::span<const PieceMesh> pieces) {
    const auto most_bodies =
        static_cast<uint32_t>(device.limits().maxStorageBufferRange / sizeof(shared::Pose));
    size_t vertices = 0, triangles = 0;
    for (size_t i = 0; i < pieces.size(); ++i) {
        if (Result<void> valid = check_piece(i, pieces[i], most_bodies); !valid) return valid.error();
        vertices += pieces[i].positions.size() + 3 * size_t{pieces[i].exterior_triangles}; // split at most so
        triangles += pieces[i].triangles.size();
    }
    // Vertex offsets are signed 32 bits, first indices unsigned 32 bits.
    if (vertices > std::numeric_limits<int32_t>::max() || triangles > std::numeric_limits<uint32_t>::max() / 3
        || 2 * pieces.size() > device.limits().maxStorageBufferRange / sizeof(shared::DrawData))
        return Error{Status::invalid_argument, "cannot draw " + std::to_string(pieces.size()) + " pieces of "
                                                   + std::to_string(triangles)
                                                   + " triangles: too many to address"};

    Arrays arrays;
    arrays.indices.reserve(3 * triangles);
    arrays.pieces = static_cast<uint32_t>(pieces.size());
    for (uint32_t index = 0; index < arrays.pieces; ++index) {
        const PieceMesh& piece = pieces[index];
        const glm::vec4 sphere = sphere_around(piece.positions);
        const auto add_range = [&](std::span<const glm::uvec3> range, uint32_t material) {
            if (range.empty()) return;
            const auto draw = static_cast<uint32_t>(arrays.draws.size());
            arrays.commands.push_back({static_cast<uint32_t>(3 * range.size()), 1,
                                       static_cast<uint32_t>(arrays.indices.size()),
                                       static_cast<int32_t>(arrays.vertices.size()), draw});
            arrays.draws.push_back(
                {piece.body, material, glm::packUnorm4x8(glm::vec4(piece.tint, 1.0f)), index, sphere});
            for (const glm::uvec3& corner : range)
                arrays.indices.insert(arrays.indices.end(), {corner.x, corner.y, corner.z});
        };
        const SmoothSurface exterior =
            smooth_normals(piece.positions, piece.triangles.first(piece.exterior_triangles));
        add_range(exterior.triangles, shared::material_exterior);
        add_range(piece.triangles.subspan(piece.exterior_triangles), shared::material_interior);
        arrays.vertices.insert(arrays.vertices.end(), piece.positions.begin(), piece.positions.end());
        for (const uint32_t vertex : exterior.copies) arrays.vertices.push_back(piece.positions[vertex]);
        arrays.normals.insert(arrays.normals.end(), exterior.normals.begin(), exterior.normals.end());
        arrays.bodies = std::max(arrays.bodies, piece.body + 1);
    }
    return PieceArena(device, arrays);
}

} // namespace brittle::engine
