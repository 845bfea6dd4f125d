// Polygons of files into triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// Triangulating takes quadratic time at worst, and no exporter writes polygons of this size.
inline constexpr size_t max_polygon_corners = 4096;

// Splits the polygons of one file.
class PolygonSplitter {
  public:
    // The triangles of a polygon of 3 to max_polygon_corners corners, which index positions; each names three corners
    // by their place in the polygon. Concave ones too: quads along the diagonal that gives two triangles on the same
    // side, larger ones by triangulate() in their plane. Valid until the next call.
    //
    // Nothing where the file's polygons are so tangled that all together take far longer than honest ones.
    [[nodiscard]] std::optional<std::span<const Triangle>> split(std::span<const glm::dvec3> positions,
                                                                 std::span<const uint32_t> corners);

    static constexpr const char* too_tangled = "its polygons cross themselves so often that splitting them would take "
                                               "very long; triangulate the mesh before exporting it";

  private:
    void split_quad(std::span<const glm::dvec3> positions, std::span<const uint32_t> corners);
    void split_large(std::span<const glm::dvec3> positions, std::span<const uint32_t> corners);

    std::vector<Triangle> triangles_;
    uint64_t corners_ = 0; // of all large polygons
    uint64_t tests_ = 0;   // Triangulation::vertex_tests of all
};

} // namespace brittle::fracture
