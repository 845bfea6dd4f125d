// Polygons of files into triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fracture/mesh.h"

namespace brittle::fracture {

// Triangulating takes quadratic time at worst, and no exporter writes polygons of this size.
inline constexpr size_t most_polygon_corners = 4096;

// Appends the triangles of a polygon of 3 to most_polygon_corners corners, which are vertices of the mesh. Concave ones
// too: quads along the diagonal that gives two triangles on the same side, larger ones by triangulate() in their plane.
void append_polygon(TriangleMesh& mesh, std::span<const uint32_t> corners);

} // namespace brittle::fracture
