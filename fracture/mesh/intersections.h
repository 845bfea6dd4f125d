// Finds the self-intersections of a mesh by exact predicates, without tolerances.
//
//     const Intersections found = find_intersections(mesh, 10'000'000, 100);
//     if (found.first) ... // triangles found.first->x and found.first->y intersect
//
// All functions are reentrant.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec2.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

struct Intersections {
    uint64_t pairs = 0;              // pairs of triangles that intersect
    std::optional<glm::uvec2> first; // the first pair, in ascending order of (x, y), where x < y are triangle indices
    std::vector<glm::uvec2> listed;  // the first pairs in that order, at most max_listed
    bool complete = true;            // false if the search ended at max_pairs
};

// Returns the pairs of triangles that have a point in common besides their shared vertices and edges: triangles that
// cross, touch or overlap in a plane. Triangles without area and pairs with three shared vertices are skipped. The
// search ends after `max_pairs` pairs with overlapping boxes. Preconditions: indices in range, coordinates finite and
// below 1e50.
[[nodiscard]] Intersections find_intersections(const TriangleMesh& mesh, uint64_t max_pairs, size_t max_listed = 0);

// Returns whether two triangles intersect in this sense.
[[nodiscard]] bool intersect(std::span<const glm::dvec3> positions, const Triangle& s, const Triangle& t);

// Returns the sign of det(a - d, b - d, c - d): positive if d lies on the side of the plane from which a, b, c are
// clockwise, 0 exactly if the four points are coplanar. Filtered in double, then exact.
[[nodiscard]] int orientation(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d);

} // namespace brittle::fracture
