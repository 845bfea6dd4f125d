// The surface of a piece as it is drawn: vertices with all that belongs to them, by material. What every exporter writes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "fracture/io/model.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture {

// Triangles of one material. Corners share a vertex where they agree in everything. Lists of a kind that they have
// nothing of are empty, the others have an entry a vertex.
struct DrawnPart {
    uint32_t material = no_material; // of the source; interior parts have none of its
    bool interior = false;
    std::vector<uint32_t> vertices{};           // of the piece: relative to Piece::vertices.begin
    std::vector<glm::vec3> normals{};           // unit
    std::array<std::vector<glm::vec2>, 2> uv{}; // v points down; of interior parts in metres
    std::vector<glm::vec4> colours{};
    std::vector<uint32_t> indices{}; // three a triangle, into the above
};

// Exterior parts by material, those of none first; the interior last. Parts without triangles are left out.
//
// Flat shading where the source has no normals: triangles of one triangle_source and one plane share their normal, so
// slivers get that of their plane. `source`, `sites` and `uv_by_plane` as in ExportOptions.
[[nodiscard]] std::vector<DrawnPart> drawn_parts(const Fragments& fragments, const Piece& piece, const Model* source,
                                                 std::span<const glm::dvec3> sites, bool uv_by_plane = false);

} // namespace brittle::fracture
