// Does a mesh pass through itself? Exact: no tolerance, whatever the coordinates.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

struct Intersections {
    uint64_t pairs = 0;              // of triangles
    std::optional<glm::uvec2> first; // the pair with the lowest first triangle, then second
    std::vector<glm::uvec2> listed;  // the lowest of them in that order, at most as many as asked for
    bool complete = true;            // false: max_pairs was reached
};

// Pairs of triangles that have a point in common besides the vertices and edges that they share: they cross, touch, or
// lie on each other. Triangles without area and pairs with the same three vertices do not count. At most `max_pairs`
// pairs with overlapping boxes are looked at. Indices are in range, coordinates finite and below 1e50.
[[nodiscard]] Intersections find_intersections(const TriangleMesh& mesh, uint64_t max_pairs, size_t max_listed = 0);

// The sign of the volume of a, b, c, d: positive where d lies on the side from which a, b, c turn clockwise; 0 exactly
// where they lie in one plane.
[[nodiscard]] int orientation(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d);

} // namespace brittle::fracture
