// Splits the polygons of mesh files into triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// The largest polygon accepted. Triangulation takes quadratic time at worst, and no exporter writes larger polygons.
inline constexpr size_t max_polygon_corners = 4096;

// Splits the polygons of one file, with a budget for all of them.
class PolygonSplitter {
  public:
    // Returns the triangles of a polygon of 3 to max_polygon_corners corners, which are indices into `positions`. A
    // triangle holds places in `corners`. A quad is split along the diagonal with both triangles on the same side; a
    // larger polygon, concave or not, is triangulated in its plane (triangulate()). Valid until the next call.
    //
    // Returns nothing where the polygons of the file cross themselves so often that the total time exceeds the budget.
    [[nodiscard]] std::optional<std::span<const Triangle>> split(std::span<const glm::dvec3> positions,
                                                                 std::span<const uint32_t> corners);

    static constexpr const char* too_tangled = "its polygons cross themselves so often that splitting them would take "
                                               "very long; triangulate the mesh before exporting it";

  private:
    void split_quad(std::span<const glm::dvec3> positions, std::span<const uint32_t> corners);
    void split_large(std::span<const glm::dvec3> positions, std::span<const uint32_t> corners);

    std::vector<Triangle> triangles_;
    uint64_t corners_ = 0; // of all large polygons so far
    uint64_t tests_ = 0;   // Triangulation::vertex_tests of all polygons so far
};

} // namespace brittle::fracture
