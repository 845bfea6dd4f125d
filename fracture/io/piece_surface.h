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
#include "fracture/mesh/triangle_tree.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture {

// The triangles of one material. Corners with equal attributes share a vertex. The list of an attribute that the part
// does not have is empty; other lists have one entry per vertex.
struct DrawnPart {
    uint32_t material = no_material; // of the source; no_material for the interior
    bool interior = false;
    std::vector<uint32_t> vertices{};  // of the piece, relative to Piece::vertices.begin
    std::vector<glm::vec3> normals{};  // unit
    std::vector<glm::vec4> tangents{}; // unit, perpendicular to the normal; w: the sign of the bitangent (tangents.h)
    // v points down. On interior parts the first set is in metres along the cut, and the second has the depth below the
    // outside, in metres, and 0.
    std::array<std::vector<glm::vec2>, 2> uv{};
    std::vector<glm::vec4> colours{};
    std::vector<uint32_t> indices{}; // three per triangle, into the lists above
};

struct SurfaceSettings {
    // As in ExportOptions.
    const Model* source = nullptr;
    std::span<const glm::dvec3> sites{};
    bool uv_by_plane = false;
    bool rough = false;
    const TriangleTree* outside = nullptr; // of the source's mesh, for the depth of rough cuts; or null
    std::span<const glm::vec4> tangents{}; // of the source's corners, as corner_tangents() gives them; or empty
};

// Returns the exterior parts in order of material, the one without a material first, then the interior part. Parts
// without triangles are omitted.
//
// Where the source has no normals the part is flat shaded: triangles of one triangle_source in one plane share its
// normal, so a sliver gets the normal of its plane. Rough cuts are smooth within each cut, and sharp at its border:
// the normal of a corner is the area-weighted mean of the triangles of the cut around it, except across creases.
[[nodiscard]] std::vector<DrawnPart> drawn_parts(const Fragments& fragments, const Piece& piece,
                                                 const SurfaceSettings& settings);

} // namespace brittle::fracture
