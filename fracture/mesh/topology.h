// Checks whether a triangle mesh bounds a solid: counts each kind of fault and locates the first of each.
//
// Definitions. An edge is *paired* if it is used exactly once in each direction. A mesh is closed and oriented if every
// edge is paired, and manifold if in addition the triangles around each vertex form a single fan. Vertices that no
// triangle uses do not count. Degenerate triangles (with a repeated vertex) count as triangles but take no part
// in edges and fans: their two other edges cancel. The *first* of several faults is the one with the lowest index.
// Edges are given as (smaller, larger) vertex index and ordered by the smaller, then by the larger.
//
//     const TopologyReport report = check_topology(mesh.positions.size(), mesh.triangles);
//     if (!report.manifold()) std::puts(describe(report).c_str());
//
// Not synchronised, no state: several threads may check meshes at the same time.
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
    uint64_t open_edges = 0;            // edges of one triangle only: the rims of holes
    uint64_t misoriented_edges = 0;     // edges of two triangles that traverse them in the same direction
    uint64_t non_manifold_edges = 0;    // edges of three triangles or more
    uint64_t non_manifold_vertices = 0; // vertices with several fans
    uint64_t degenerate_triangles = 0;  // triangles that name a vertex twice
    uint64_t components = 0;            // connected components, over shared vertices
    std::optional<glm::uvec2> first_open_edge;
    std::optional<glm::uvec2> first_misoriented_edge;
    std::optional<glm::uvec2> first_non_manifold_edge;
    std::optional<uint32_t> first_non_manifold_vertex;
    std::optional<uint32_t> first_degenerate_triangle;
    std::vector<uint32_t> some_non_manifold_vertices; // the lowest indices, at most max_listed_vertices of them
    static constexpr size_t max_listed_vertices = 1000;

    [[nodiscard]] bool closed() const {
        return open_edges == 0 && misoriented_edges == 0 && non_manifold_edges == 0 && degenerate_triangles == 0;
    }
    [[nodiscard]] bool manifold() const { return closed() && non_manifold_vertices == 0; }
    // V - E + F. A component of genus g contributes 2 - 2g.
    [[nodiscard]] int64_t euler_characteristic() const {
        return static_cast<int64_t>(vertices) - static_cast<int64_t>(edges) + static_cast<int64_t>(triangles);
    }
};

// Precondition: indices are below vertex_count, and there are fewer than 2^32 / 3 triangles. Deterministic. Time is
// near linear (d log d at most for a vertex of degree d); scratch memory is 24 bytes per triangle and 9 per vertex.
[[nodiscard]] TopologyReport check_topology(size_t vertex_count, std::span<const Triangle> triangles);

// Returns one sentence with all counts and the location of the first fault of the gravest kind, for example "12 open
// edges, the first between vertices 4 and 7"; an empty string for a manifold mesh.
[[nodiscard]] std::string describe(const TopologyReport& report);

// Returns the status of the gravest fault, in the order of describe(): not_closed, non_manifold (edges), not_oriented,
// invalid_mesh (degenerate triangles), non_manifold (vertices). Precondition: the mesh is not manifold.
[[nodiscard]] Status status_of(const TopologyReport& report);

// Returns the connected component of each triangle (over shared vertices), numbered by first triangle.
[[nodiscard]] std::vector<uint32_t> triangle_components(size_t vertex_count, std::span<const Triangle> triangles);

} // namespace brittle::fracture
