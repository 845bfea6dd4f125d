// The surface of a piece for drawing: vertices with all attributes, grouped by material. Every exporter writes these
// parts.
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

// The triangles of one material. Corners with equal attributes share a vertex. The list of an attribute that the part
// does not have is empty; other lists have one entry per vertex.
struct DrawnPart {
    uint32_t material = no_material; // of the source; no_material for the interior
    bool interior = false;
    std::vector<uint32_t> vertices{};           // of the piece, relative to Piece::vertices.begin
    std::vector<glm::vec3> normals{};           // unit
    std::array<std::vector<glm::vec2>, 2> uv{}; // v points down; in metres on interior parts
    std::vector<glm::vec4> colours{};
    std::vector<uint32_t> indices{}; // three per triangle, into the lists above
};

// Returns the exterior parts in order of material, the one without a material first, then the interior part. Parts
// without triangles are omitted.
//
// Where the source has no normals the part is flat shaded: triangles of one triangle_source in one plane share its
// normal, so a sliver gets the normal of its plane. `source`, `sites` and `uv_by_plane` as in ExportOptions.
[[nodiscard]] std::vector<DrawnPart> drawn_parts(const Fragments& fragments, const Piece& piece, const Model* source,
                                                 std::span<const glm::dvec3> sites, bool uv_by_plane = false);

} // namespace brittle::fracture
