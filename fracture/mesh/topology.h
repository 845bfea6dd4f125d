// Is a triangle mesh the boundary of a solid? Counts of what is wrong, and the first offender of each kind.
//
// Definitions: an edge is *paired* when it is used once in each direction. A mesh is closed and oriented when
// every edge is paired, and manifold when besides the triangles around each vertex form a single fan.
// Vertices that no triangle uses do not count. Degenerate triangles (a vertex named twice) count as triangles
// but take no part in edges and fans: their two other edges cancel. *First* means lowest index; of edges,
// lowest smaller end, then larger end, and an offending edge is given as (smaller, larger).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

struct TopologyReport {
    uint64_t vertices = 0; // used by at least one triangle
    uint64_t edges = 0;    // undirected
    uint64_t triangles = 0;
    uint64_t open_edges = 0;            // used by one triangle only: the rim of a hole
    uint64_t misoriented_edges = 0;     // used by two triangles, both in the same direction
    uint64_t non_manifold_edges = 0;    // used by three triangles or more
    uint64_t non_manifold_vertices = 0; // several fans meet in one vertex
    uint64_t degenerate_triangles = 0;  // a triangle that names a vertex twice
    uint64_t components = 0;            // connected over shared vertices
    std::optional<glm::uvec2> first_open_edge;
    std::optional<glm::uvec2> first_misoriented_edge;
    std::optional<glm::uvec2> first_non_manifold_edge;
    std::optional<uint32_t> first_non_manifold_vertex;
    std::optional<uint32_t> first_degenerate_triangle;
    std::vector<uint32_t> some_non_manifold_vertices; // the lowest, at most max_listed_vertices
    static constexpr size_t max_listed_vertices = 1000;

    [[nodiscard]] bool closed() const {
        return open_edges == 0 && misoriented_edges == 0 && non_manifold_edges == 0 && degenerate_triangles == 0;
    }
    [[nodiscard]] bool manifold() const { return closed() && non_manifold_vertices == 0; }
    // V - E + F; 2 per component of genus 0.
    [[nodiscard]] int64_t euler_characteristic() const {
        return static_cast<int64_t>(vertices) - static_cast<int64_t>(edges) + static_cast<int64_t>(triangles);
    }
};

// Indices must be below vertex_count, triangles fewer than 2^32 / 3. Deterministic; near-linear time (a
// vertex of degree d costs d log d at most), and 24 bytes a triangle plus 9 a vertex of scratch memory.
[[nodiscard]] TopologyReport check_topology(size_t vertex_count, std::span<const Triangle> triangles);

// One sentence for people about what is wrong, with counts and the first offender of the gravest kind, e.g.
// "12 open edges, the first between vertices 4 and 7"; empty where nothing is.
[[nodiscard]] std::string describe(const TopologyReport& report);

// The error that names the gravest fault, in the order of describe(): not_closed, non_manifold (edges),
// not_oriented, invalid_mesh (degenerate triangles), non_manifold (vertices). The mesh must not be manifold.
[[nodiscard]] Status status_of(const TopologyReport& report);

// The connected component of each triangle (over shared vertices), numbered by first triangle.
[[nodiscard]] std::vector<uint32_t> triangle_components(size_t vertex_count, std::span<const Triangle> triangles);

} // namespace brittle::fracture
